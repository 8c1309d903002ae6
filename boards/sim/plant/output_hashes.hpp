// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "firmware/hal/io.hpp"
#include "shared/hash/sha256.hpp"

namespace sc::sim {

/// Hashes of what a controller asked for, over ticks in order. They depend on the job alone: not on when it began, nor
/// how long the axes waited between its paths.
class OutputHashes {
public:
    void tick(const ServoOutputs& outputs);
    [[nodiscard]] std::string commands() const;
    [[nodiscard]] std::string set_points() const;
    [[nodiscard]] std::string laser() const;

private:
    Sha256 commands_;
    Sha256 set_points_;
    Sha256 laser_;
    AxisPositions before_{};
    std::int64_t last_run_ns_ = 0;
};

}  // namespace sc::sim
