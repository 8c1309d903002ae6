// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sc::stm32h743 {

/// The three LEDs of the board.
struct Lights {
    bool green = false;
    bool yellow = false;
    bool red = false;
};

void start_lights() noexcept;
void show(const Lights& lights) noexcept;

/// One of `count` blinks, 0.25 s on and 0.25 s off, then 1 s of dark; `tick` in ms.
[[nodiscard]] constexpr bool blinks(std::uint32_t tick, std::uint32_t count) noexcept {
    const std::uint32_t place = tick % (500 * count + 1'000);
    return place < 500 * count && place % 500 < 250;
}
static_assert(blinks(0, 1) && !blinks(250, 1) && !blinks(500, 1) && blinks(1'500, 1));
static_assert(blinks(500, 2) && !blinks(1'000, 2) && !blinks(0, 0));

}  // namespace sc::stm32h743
