// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an500/image/fault.hpp"

#include <atomic>

#include "boards/mps2_an500/image/board_ram.hpp"
#include "boards/mps2_an500/image/registers.hpp"

namespace sc::mps2_an500 {
namespace {

constexpr std::uintptr_t kDataBegin = 0x2000'0000;
constexpr std::uintptr_t kDataEnd = 0x2040'0000;
constexpr std::size_t kStackedWords = 8;  ///< r0-r3, r12, lr, pc, xpsr

bool readable(std::uintptr_t frame) noexcept {
    return frame % 4 == 0 && frame >= kDataBegin && frame <= kDataEnd - 4 * kStackedWords;
}

}  // namespace

void halt(const FaultRecord& record) noexcept {
    asm volatile("cpsid i" ::: "memory");
    SharedRam& ram = shared_ram();
    ram.outputs_size = 0;
    ram.answer = static_cast<std::uint32_t>(Answer::none);
    ram.fault = record;
    set_core_state(CoreState::halted);
    while (true) {
        asm volatile("wfi");
    }
}

}  // namespace sc::mps2_an500

extern "C" {

[[gnu::used]] void record_exception(std::uint32_t sp, std::uint32_t exception) noexcept {
    using namespace sc::mps2_an500;
    FaultRecord record;
    record.cause = static_cast<std::uint32_t>(HaltCause::exception);
    record.exception = exception;
    record.sp = sp;
    if (readable(sp)) {
        const auto* stacked = reinterpret_cast<const std::uint32_t*>(std::uintptr_t{sp});
        record.lr = stacked[5];
        record.pc = stacked[6];
        record.xpsr = stacked[7];
    }
    record.cfsr = configurable_fault_status();
    record.hfsr = hard_fault_status();
    record.mmfar = memory_fault_address();
    record.bfar = bus_fault_address();
    halt(record);
}

/// Of every exception that is not meant to happen. On a stack of its own: the fault may be that the other is full.
[[gnu::naked]] void fault_handler() {
    asm volatile(
        "mov r0, sp\n"
        "mrs r1, ipsr\n"
        "ldr r2, =fault_stack_top\n"
        "mov sp, r2\n"
        "b record_exception\n"
        ".ltorg\n");
}

/// What the language's run time ends in.
[[noreturn]] void abort() {
    sc::mps2_an500::FaultRecord record;
    record.cause = static_cast<std::uint32_t>(sc::mps2_an500::HaltCause::panic);
    record.lr = static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(__builtin_return_address(0)));
    sc::mps2_an500::halt(record);
}

}  // extern "C"
