// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdint>

#include "boards/mps2_an500/image/registers.hpp"
#include "boards/mps2_an500/image/uart.hpp"

extern "C" {

// Of the linker script.
extern std::uint32_t stack_top[];
extern std::uint32_t data_begin[];
extern std::uint32_t data_end[];
extern const std::uint32_t data_image[];
extern std::uint32_t bss_begin[];
extern std::uint32_t bss_end[];
using Constructor = void (*)();
extern const Constructor init_array_begin[];
extern const Constructor init_array_end[];

void fault_handler();
[[noreturn]] void board_main();

/// Paints the stack and switches the FPU on before any compiled code, which may use both.
[[gnu::naked, gnu::used, noreturn]] void reset_handler() {
    asm volatile(
        "ldr r0, =stack_bottom\n"
        "ldr r1, =stack_top\n"
        "ldr r2, =0xA5C396E1\n"  // kStackPaint
        "1: str r2, [r0], #4\n"
        "cmp r0, r1\n"
        "blo 1b\n"
        "ldr r0, =0xE000ED88\n"  // CPACR: full access to coprocessors 10 and 11
        "ldr r1, [r0]\n"
        "orr r1, r1, #0xF00000\n"
        "str r1, [r0]\n"
        "dsb\n"
        "isb\n"
        "b start\n"
        ".ltorg\n");
}

[[gnu::used, noreturn]] void start() {
    using namespace sc::mps2_an500;
    std::copy(data_image, data_image + (data_end - data_begin), data_begin);
    std::fill(bss_begin, bss_end, 0U);
    system_handlers() = system_handlers() | kMemoryBusUsageFaults;
    protection_base() = kBelowDataRam;
    protection_attributes() = kNoAccess256Mb;
    protection_control() = kProtectionOverDefaultMap;
    asm volatile("dsb\nisb" ::: "memory");
    configuration_control() = configuration_control() | kTrapDivisionByZero;
    for (const Constructor* constructor = init_array_begin; constructor != init_array_end; ++constructor) {
        (*constructor)();
    }
    board_main();
}

union Vector {
    std::uint32_t* stack;
    void (*handler)();
};
constexpr std::size_t kFirstInterrupt = 16;
constexpr std::size_t kInterrupts = 32;

using VectorTable = std::array<Vector, kFirstInterrupt + kInterrupts>;
extern const VectorTable vector_table;
[[gnu::section(".vectors"), gnu::used]] constinit const VectorTable vector_table = [] {
    VectorTable table{};
    table.fill(Vector{.handler = fault_handler});
    table[0].stack = stack_top;
    table[1].handler = reset_handler;
    table[kFirstInterrupt + sc::mps2_an500::kUart0ReceiveInterrupt].handler = sc::mps2_an500::uart_receive_isr;
    return table;
}();

}  // extern "C"
