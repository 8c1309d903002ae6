// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/world/world_error.hpp"

#include <utility>

namespace sc::sim {
namespace {

std::string one_line(const WorldError::Detail& d) {
    std::string text = d.file;
    if (d.line != 0) {
        text += ":" + std::to_string(d.line);
    }
    text += ": ";
    if (!d.value.empty()) {
        text += "'" + d.value + "': ";
    }
    return text + d.problem + "; " + d.action;
}

}  // namespace

WorldError::WorldError(Detail detail) : std::runtime_error(one_line(detail)), detail_(std::move(detail)) {}

}  // namespace sc::sim
