// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>

#include "firmware/hal/io.hpp"

namespace sc::replay {

/// Tables of what a replay did, to look at elsewhere: ticks.csv, a line a tick, and commands.csv, a line a pulse.
class ReplayFiles {
public:
    /// Makes the folder. Throws std::system_error.
    explicit ReplayFiles(const std::filesystem::path& folder);

    void tick(const ServoInputs& inputs, const ServoOutputs& outputs);
    /// Throws std::runtime_error when the disk has refused anything.
    void close();

private:
    std::filesystem::path folder_;
    std::ofstream ticks_;
    std::ofstream commands_;
};

}  // namespace sc::replay
