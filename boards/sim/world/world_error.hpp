// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace sc::sim {

/// A file given to the simulated cell (world, mesh, script) that cannot be used. `what()` is one line with all of it.
class WorldError : public std::runtime_error {
public:
    /// Where and what: `line` 0 when no single line is to blame, `value` empty when there is none to show.
    struct Detail {
        std::string file;
        std::size_t line = 0;
        std::string value;
        std::string problem;
        std::string action;
    };
    explicit WorldError(Detail detail);
    [[nodiscard]] const Detail& detail() const noexcept { return detail_; }

private:
    Detail detail_;
};

}  // namespace sc::sim
