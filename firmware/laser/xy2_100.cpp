// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/xy2_100.hpp"

namespace sc::laser {

FieldMap::FieldMap(const Compensation& compensation, const GalvoConfig& galvo) noexcept
    : flip_(xy2_100_flip(galvo.convention)) {
    for (std::size_t i = 0; i < m_.size(); ++i) {
        m_[i] = compensation.galvo_from_field[i] * galvo.counts_per_metre;
    }
    for (std::size_t i = 0; i < offset_.size(); ++i) {
        offset_[i] = compensation.galvo_offset[i] * galvo.counts_per_metre;
    }
}

}  // namespace sc::laser
