// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <cstdlib>

#include "boards/stm32h743/registers/fault_registers.hpp"
#include "boards/stm32h743/system/fault_record.hpp"

/// Where every exception ends that is not meant to happen, and the warning of the window watchdog: outputs safe, a
/// record, reset.

extern "C" {

[[gnu::used, noreturn]] void end_in_reset(std::uint32_t sp, std::uint32_t exception) noexcept {
    using namespace sc::stm32h743;
    make_outputs_safe();
    leave_fault_record(gather_fault(exception, sp));
    write32(fault_registers::kAircr, fault_registers::kResetRequest);
    barrier();
    while (true) {
    }
}

/// On a stack of its own: the fault may be that the other is full.
[[gnu::naked]] void fault_handler() {
    asm volatile(
        "cpsid i\n"
        "mov r0, sp\n"
        "mrs r1, ipsr\n"
        "ldr r2, =fault_stack_top\n"
        "mov sp, r2\n"
        "b end_in_reset\n"
        ".ltorg\n");
}

/// What the language's run time ends in.
[[noreturn]] void abort() {
    using namespace sc::stm32h743;
    asm volatile("cpsid i" ::: "memory");
    make_outputs_safe();
    FaultRecord record = gather_fault(0, 0);
    record.lr = static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(__builtin_return_address(0)));
    leave_fault_record(record);
    write32(fault_registers::kAircr, fault_registers::kResetRequest);
    barrier();
    while (true) {
    }
}

}  // extern "C"
