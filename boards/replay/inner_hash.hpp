// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "firmware/controller/controller.hpp"
#include "shared/hash/sha256.hpp"

namespace sc::replay {

/// A hash over what the controller has computed and not yet rounded: the speed on the path, every new piece of the
/// trajectory, nominal or re-timed, to the last bit. Outputs are integers in picometres and nanoseconds; most
/// differences in the last bit of a double vanish there, and show only in a longer job.
class InnerHash {
public:
    /// After each tick.
    void add(const Controller& controller);
    [[nodiscard]] std::string hexadecimal() const;

private:
    void add_pieces(const trajectory::Ring<motion::Piece>& pieces, std::uint32_t& known);

    Sha256 hash_;
    std::uint32_t planned_ = 0;  ///< pieces with numbers below are in the hash
    std::uint32_t made_ = 0;
};

}  // namespace sc::replay
