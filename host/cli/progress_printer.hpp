// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "host/bridge/progress.hpp"

namespace sc::host::cli {

/// Progress of a job on stderr: a bar that is drawn over and over where a person looks at a terminal, one line for
/// every tenth where the output goes to a file.
class ProgressPrinter {
public:
    explicit ProgressPrinter(bool terminal) : terminal_(terminal) {}
    ~ProgressPrinter() { end_line(); }
    ProgressPrinter(const ProgressPrinter&) = delete;
    ProgressPrinter& operator=(const ProgressPrinter&) = delete;

    void show(const Progress& progress);
    /// A step that has no length, such as "homing".
    void step(const std::string& what);
    /// Ends a bar that stands on the present line.
    void end_line();

private:
    bool terminal_;
    bool bar_open_ = false;
    int tenths_shown_ = 0;
};

/// True when stderr is a terminal.
[[nodiscard]] bool stderr_is_terminal();
/// "1:02:03", "2:05" or "0:07"; whole seconds, rounded up.
[[nodiscard]] std::string clock_text(Nanoseconds time);

}  // namespace sc::host::cli
