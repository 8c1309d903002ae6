// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/store/backup_ram.hpp"

#include "boards/stm32h743/registers/backup.hpp"
#include "boards/stm32h743/store/fault_guard.hpp"

namespace sc::stm32h743 {
namespace {

namespace regs = backup_registers;

constexpr std::uint32_t kReadsForRegulator = 200'000;  // 2 ms

bool readable(Address at) noexcept {
    const FaultGuard guard;
    (void)read32(at);
    return !guard.failed();
}

}  // namespace

BackupStart start_backup_ram() noexcept {
    BackupStart start;
    set_bits(regs::kAhb4enr, regs::kRamClock);
    set_bits(regs::kPwrCr1, regs::kAccess);
    barrier();
    if (!wait_for(regs::kPwrCr1, regs::kAccess, true, 100)) {
        start.result = BackupStart::Result::read_only;
        return start;
    }
    set_bits(regs::kPwrCr2, regs::kRegulator);
    if (!wait_for(regs::kPwrCr2, regs::kRegulatorReady, true, kReadsForRegulator)) {
        start.result = BackupStart::Result::no_regulator;
    }
    for (Address at = kBackupRam; at < kBackupRam + kBackupRamBytes; at += 4) {
        if (!readable(at)) {
            write32(at, 0);
            ++start.lost_words;
        }
    }
    barrier();
    return start;
}

}  // namespace sc::stm32h743
