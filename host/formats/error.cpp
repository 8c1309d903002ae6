// SPDX-License-Identifier: Apache-2.0
#include "host/formats/error.hpp"

#include <utility>

namespace sc::host {

namespace {

std::string line_of(const InputProblem& p) {
    std::string out = p.file;
    if (!out.empty()) {
        out += p.line > 0 ? ":" + std::to_string(p.line) + ": " : ": ";
    }
    out += p.problem;
    if (!p.value.empty()) {
        out += ": " + p.value;
    }
    if (!p.action.empty()) {
        out += "; " + p.action;
    }
    return out;
}

}  // namespace

InputError::InputError(InputProblem problem) : std::runtime_error(line_of(problem)), problem_(std::move(problem)) {}

}  // namespace sc::host
