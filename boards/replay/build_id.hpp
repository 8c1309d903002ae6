// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sc::replay {

/// Version, commit at configure time and compiler of this program: what a log says that it was recorded by.
[[nodiscard]] std::string build_id();

}  // namespace sc::replay
