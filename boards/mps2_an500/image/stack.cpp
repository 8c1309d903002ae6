// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an500/image/stack.hpp"

extern "C" {
// Of the linker script.
extern std::uint32_t stack_bottom[];
extern std::uint32_t stack_top[];
}

namespace sc::mps2_an500 {

std::uint32_t stack_size() noexcept {
    return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(stack_top) -
                                      reinterpret_cast<std::uintptr_t>(stack_bottom));
}

void repaint_stack() noexcept {
    std::uint32_t here = 0;
    asm volatile("mov %0, sp" : "=r"(here));
    for (volatile std::uint32_t* word = stack_bottom; reinterpret_cast<std::uintptr_t>(word) < here; ++word) {
        *word = kStackPaint;
    }
}

std::uint32_t stack_used() noexcept {
    const volatile std::uint32_t* word = stack_bottom;
    while (word != stack_top && *word == kStackPaint) {
        ++word;
    }
    return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(stack_top) -
                                      reinterpret_cast<std::uintptr_t>(word));
}

}  // namespace sc::mps2_an500
