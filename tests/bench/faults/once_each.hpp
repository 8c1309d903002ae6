// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "tests/bench/faults/pins.hpp"

namespace sc::faults {

/// What the burns from number `from` on have otherwise than those of `trace.path`, one by one; empty: nothing. For a
/// job that was held on its way: no pulse twice, none missing.
[[nodiscard]] std::string once_each(const Trace& trace, std::size_t from);

}  // namespace sc::faults
