// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sc::mps2_an500 {

inline constexpr std::uint32_t kStackPaint = 0xA5C3'96E1;

/// Bytes of the stack.
[[nodiscard]] std::uint32_t stack_size() noexcept;
/// Paints again what is not in use, so that what follows is measured apart from what was before.
void repaint_stack() noexcept;
/// Bytes from the top down to the lowest word that no longer has the paint of the start-up. Reads all that is unused.
[[nodiscard]] std::uint32_t stack_used() noexcept;

}  // namespace sc::mps2_an500
