// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <iterator>

#include "boards/stm32h743/registers/access.hpp"
#include "boards/stm32h743/registers/core_memory.hpp"
#include "boards/stm32h743/system/interrupts.hpp"
#include "boards/stm32h743/system/memory_map.hpp"
#include "boards/stm32h743/system/memory_start.hpp"

extern "C" {

// Of the linker script.
extern std::uint32_t stack_top[];
extern std::uint32_t itcm_begin[];
extern std::uint32_t itcm_end[];
extern const std::uint32_t itcm_image[];
extern std::uint32_t data_begin[];
extern std::uint32_t data_end[];
extern const std::uint32_t data_image[];
extern std::uint32_t bss_begin[];
extern std::uint32_t bss_end[];
extern std::uint32_t axi_begin[];
extern std::uint32_t axi_end[];
extern std::uint32_t sram1_begin[];
extern std::uint32_t sram1_end[];
extern std::uint32_t sram2_begin[];
extern std::uint32_t sram2_end[];
extern std::uint32_t sram3_begin[];
extern std::uint32_t sram3_end[];
using Constructor = void (*)();
extern const Constructor init_array_begin[];
extern const Constructor init_array_end[];

void fault_handler();
[[noreturn]] void board_main();

// Where the drivers enter. The linker script gives fault_handler to those that an image has not.
void exti9_5_isr();
void tim7_isr();
void dma1_stream0_isr();
void usart2_isr();
void usart6_isr();
void uart4_isr();
void fdcan1_it0_isr();
void fdcan2_it0_isr();
void usart3_isr();
void pendsv_isr();

union Vector {
    std::uint32_t* stack;
    void (*handler)();
};
constexpr std::size_t kFirstInterrupt = 16;
constexpr std::size_t kInterrupts = 150;
using VectorTable = std::array<Vector, kFirstInterrupt + kInterrupts>;
extern const VectorTable vector_table;
/// The table in force: in DTCM, so that entering an interrupt does not wait for the flash. `alignas`: VTOR.
[[gnu::section(".vectors_ram")]] alignas(1024) VectorTable vectors_in_ram;

/// Paints the stack and switches the FPU on before any compiled code, which may use both. A boot loader may have
/// left another stack and interrupts on.
[[gnu::naked, gnu::used, noreturn]] void reset_handler() {
    asm volatile(
        "cpsid i\n"
        "ldr r0, =stack_top\n"
        "msr msp, r0\n"
        "ldr r0, =stack_bottom\n"
        "ldr r1, =stack_top\n"
        "ldr r2, =0xA5C396E1\n"  // paint, to measure how deep the stack was
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
    using namespace sc::stm32h743;
    constexpr Address kVtor = 0xE000ED08;
    // A boot loader may have closed ITCM. Protection closes it again below.
    barrier();
    write32(core_memory::kMpuCtrl, 0);
    barrier();
    std::copy(itcm_image, itcm_image + (itcm_end - itcm_begin), itcm_begin);
    std::copy(data_image, data_image + (data_end - data_begin), data_begin);
    std::fill(bss_begin, bss_end, 0U);
    std::ranges::copy(vector_table, vectors_in_ram.begin());
    write32(kVtor, address_of(vectors_in_ram.data()));
    barrier();
    instruction_barrier();
    if (!start_memory(address_of(&vector_table) >= memory::kBank2.base ? 2 : 1)) {
        std::abort();
    }
    std::fill(axi_begin, axi_end, 0U);
    std::fill(sram1_begin, sram1_end, 0U);
    std::fill(sram2_begin, sram2_end, 0U);
    std::fill(sram3_begin, sram3_end, 0U);
    for (const Constructor* constructor = init_array_begin; constructor != init_array_end; ++constructor) {
        (*constructor)();
    }
    prepare_interrupts();
    asm volatile("cpsie i" ::: "memory");
    board_main();
}

struct Entry {
    int number;
    void (*handler)();
};
constexpr Entry kEntries[]{{23, exti9_5_isr},      {55, tim7_isr},
                           {11, dma1_stream0_isr}, {38, usart2_isr},
                           {71, usart6_isr},       {52, uart4_isr},
                           {19, fdcan1_it0_isr},   {20, fdcan2_it0_isr},
                           {39, usart3_isr},       {sc::stm32h743::kPendSv, pendsv_isr}};
/// Each context of interrupts.hpp is entered, and nothing else is.
constexpr bool entries_are_complete() {
    using namespace sc::stm32h743;
    const auto interrupts = std::ranges::count_if(kContexts, [](const Context& one) { return one.number != kThread; });
    return interrupts == std::ssize(kEntries) && std::ranges::all_of(kEntries, [](const Entry& entry) {
               return std::ranges::any_of(kContexts, [&](const Context& one) { return one.number == entry.number; });
           });
}
static_assert(entries_are_complete());

// What has no entry is a fault; so is the warning of the window watchdog, which leaves a record of where it came.
[[gnu::section(".vectors"), gnu::used]] constinit const VectorTable vector_table = [] {
    VectorTable table{};
    table.fill(Vector{.handler = fault_handler});
    table[0].stack = stack_top;
    table[1].handler = reset_handler;
    for (const Entry& entry : kEntries) {
        table[static_cast<std::size_t>(static_cast<int>(kFirstInterrupt) + entry.number)].handler = entry.handler;
    }
    return table;
}();

}  // extern "C"
