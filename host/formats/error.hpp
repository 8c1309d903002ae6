// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace sc::host {

/// What is wrong with something a person gave us: where it stands, what was found there and what to do about it.
struct InputProblem {
    std::string file = {};     ///< path as it was given; empty = not from a file
    int line = 0;              ///< from 1; 0 = the file as a whole
    std::string problem = {};  ///< what is wrong, without the value
    std::string value = {};    ///< the offending text or number; empty = none (a missing file, say)
    std::string action = {};   ///< what to do, as an imperative
};

/// Bad input: the program ends with exit code 2 and nothing has been started. `what()` is one line for a person:
/// "FILE:LINE: problem: VALUE; action" (parts that are empty are left out).
class InputError : public std::runtime_error {
public:
    explicit InputError(InputProblem problem);
    [[nodiscard]] const std::string& file() const noexcept { return problem_.file; }
    [[nodiscard]] int line() const noexcept { return problem_.line; }
    [[nodiscard]] const std::string& problem() const noexcept { return problem_.problem; }
    [[nodiscard]] const std::string& value() const noexcept { return problem_.value; }
    [[nodiscard]] const std::string& action() const noexcept { return problem_.action; }

private:
    InputProblem problem_;
};

}  // namespace sc::host
