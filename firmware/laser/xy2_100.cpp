// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/xy2_100.hpp"

namespace sc::laser {

FieldMap::FieldMap(const Compensation& compensation, const GalvoConfig& galvo) noexcept
    : format_(galvo.word, galvo.convention) {
    const double counts_per_metre = galvo.counts_per_metre * format_.scale();
    for (std::size_t i = 0; i < m_.size(); ++i) {
        m_[i] = compensation.galvo_from_field[i] * counts_per_metre;
    }
    for (std::size_t i = 0; i < offset_.size(); ++i) {
        offset_[i] = compensation.galvo_offset[i] * counts_per_metre;
    }
}

}  // namespace sc::laser
