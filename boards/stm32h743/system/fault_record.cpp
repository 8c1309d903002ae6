// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/system/fault_record.hpp"

#include <bit>

#include "boards/stm32h743/registers/fault_registers.hpp"
#include "boards/stm32h743/system/memory_map.hpp"
#include "boards/stm32h743/system/pins.hpp"

namespace sc::stm32h743 {

namespace regs = fault_registers;

namespace {

constexpr Address kStart = memory::kFaultRecord.base;
constexpr Address kCheck = kStart + 4 * kFaultRecordWords;
constexpr Address kFlush = kCheck + 4;
static_assert(kFlush + 4 == kStart + kFaultRecordBytes && kFaultRecordBytes <= memory::kFaultRecord.bytes);
static_assert(sizeof(FaultRecord) == 4 * kFaultRecordWords);

using Words = std::array<std::uint32_t, kFaultRecordWords>;

std::uint32_t tick_now = 0;

/// FNV-1a over words; never 0, as RAM without power may be.
std::uint32_t check_of(const Words& words) noexcept {
    std::uint32_t hash = 2'166'136'261U;
    for (const std::uint32_t word : words) {
        hash = (hash ^ word) * 16'777'619U;
        hash ^= hash >> 15U;
    }
    return hash | 1U;
}

/// 1 in both bits of each pin, and in the lower of both.
constexpr std::uint32_t modes(std::uint32_t pins, std::uint32_t mode) noexcept {
    std::uint32_t bits = 0;
    for (unsigned pin = 0; pin < 16; ++pin) {
        bits |= (pins >> pin & 1U) != 0 ? mode << (2U * pin) : 0U;
    }
    return bits;
}

template <std::uint32_t kPins>
void hold_low(Address port) noexcept {
    write32(port + regs::kBsrr, kPins << 16U);
    change_bits(port + regs::kModer, modes(kPins, 3), modes(kPins, 1));
}

bool open_backup_ram() noexcept {
    set_bits(regs::kAhb4enr, regs::kBackupRamClock);
    (void)read32(regs::kAhb4enr);  // the clock is there two cycles later
    set_bits(regs::kPwrCr1, regs::kUnlockBackup);
    return wait_for(regs::kPwrCr1, regs::kUnlockBackup, true, 1'000);
}

}  // namespace

void make_outputs_safe() noexcept {
    set_bits(regs::kAhb4enr, regs::kGpioEClock | regs::kGpioFClock);
    (void)read32(regs::kAhb4enr);  // the clock is there two cycles later
    hold_low<kSafeLowE>(regs::kGpioE);
    hold_low<kSafeLowF>(regs::kGpioF);
    if ((read32(regs::kApb2enr) & regs::kTim1Clock) != 0) {
        clear_bits(regs::kTim1Bdtr, regs::kMainOutput);
    }
    barrier();
}

bool start_fault_records() noexcept {
    set_bits(regs::kShcsr, regs::kMemManage | regs::kBusFault | regs::kUsageFault);
    return open_backup_ram();
}

void note_tick(std::uint32_t tick) noexcept { tick_now = tick; }

FaultRecord gather_fault(std::uint32_t exception, std::uint32_t sp) noexcept {
    constexpr std::uint32_t kFrameBytes = 32;  // r0-r3, r12, lr, pc, xpsr
    FaultRecord record;
    record.exception = exception;
    record.tick = tick_now;
    record.sp = sp;
    if (sp % 4 == 0 && sp >= memory::kDtcm.base && sp - memory::kDtcm.base <= memory::kDtcm.bytes - kFrameBytes) {
        record.lr = read32(sp + 20);
        record.pc = read32(sp + 24);
        record.xpsr = read32(sp + 28);
    }
    // The addresses first: a further fault takes them.
    const std::uint32_t memory_address = read32(regs::kMmfar);
    const std::uint32_t bus_address = read32(regs::kBfar);
    record.cfsr = read32(regs::kCfsr);
    record.hfsr = read32(regs::kHfsr);
    record.abfsr = read32(regs::kAbfsr);
    record.memory_address = (record.cfsr & regs::kMmarValid) != 0 ? memory_address : 0;
    record.bus_address = (record.cfsr & regs::kBfarValid) != 0 ? bus_address : 0;
    record.clock_flags = read32(regs::kCifr);
    record.flash_bank1 = read32(regs::kFlashSr1);
    record.flash_bank2 = read32(regs::kFlashSr2);
    return record;
}

void leave_fault_record(const FaultRecord& record) noexcept {
    if (!open_backup_ram()) {
        return;
    }
    const Words words = std::bit_cast<Words>(record);
    for (std::size_t i = 0; i < words.size(); ++i) {
        write32(kStart + 4 * static_cast<Address>(i), words[i]);
    }
    write32(kCheck, check_of(words));
    // An ECC RAM may hold back its last write until the next one; a reset in between would lose it.
    write32(kFlush, 0);
    barrier();
}

std::optional<FaultRecord> take_fault_record() noexcept {
    if (!open_backup_ram()) {
        return std::nullopt;
    }
    Words words{};
    for (std::size_t i = 0; i < words.size(); ++i) {
        words[i] = read32(kStart + 4 * static_cast<Address>(i));
    }
    if (read32(kCheck) != check_of(words)) {
        return std::nullopt;
    }
    write32(kCheck, 0);
    write32(kFlush, 0);
    barrier();
    return std::bit_cast<FaultRecord>(words);
}

}  // namespace sc::stm32h743
