// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/system/memory_start.hpp"

#include <bit>

#include "boards/stm32h743/registers/core_memory.hpp"
#include "boards/stm32h743/system/memory_map.hpp"

namespace sc::stm32h743 {
namespace {

namespace regs = core_memory;

constexpr std::uint32_t attributes(const ProtectedRange& one) noexcept {
    std::uint32_t word = regs::kRegionEnable | (static_cast<std::uint32_t>(std::bit_width(one.range.bytes)) - 2) << 1U;
    word |= one.execute ? 0U : regs::kNeverExecute;
    switch (one.access) {
        case Access::none: break;
        case Access::read_only: word |= regs::kReadOnly; break;
        case Access::read_write: word |= regs::kReadWrite; break;
    }
    switch (one.caching) {
        case Caching::not_cached: word |= regs::kTypeExtension1; break;
        case Caching::write_through: word |= regs::kCacheable; break;
        case Caching::write_back: word |= regs::kTypeExtension1 | regs::kCacheable | regs::kBufferable; break;
    }
    return word;
}

bool protect(unsigned bank) noexcept {
    const auto plan = protection(bank);
    const std::uint32_t regions = (read32(regs::kMpuType) & regs::kRegionCount) >> regs::kRegionCountShift;
    if (regions < plan.size()) {
        return false;
    }
    barrier();
    write32(regs::kMpuCtrl, 0);
    for (std::uint32_t i = 0; i < regions; ++i) {
        write32(regs::kMpuRnr, i);
        if (i < plan.size()) {
            write32(regs::kMpuRbar, plan[i].range.base);
            write32(regs::kMpuRasr, attributes(plan[i]));
        } else {
            write32(regs::kMpuRasr, 0);
        }
    }
    write32(regs::kMpuCtrl, regs::kMpuEnable | regs::kDefaultMap);
    barrier();
    instruction_barrier();
    return true;
}

/// Not again when it is on: what was written would be lost.
void start_data_cache() noexcept {
    if ((read32(regs::kCcr) & regs::kDataCache) != 0) {
        return;
    }
    write32(regs::kCsselr, 0);
    barrier();
    for (std::uint32_t set = 0; set < regs::kDataCacheSets; ++set) {
        for (std::uint32_t way = 0; way < regs::kDataCacheWays; ++way) {
            write32(regs::kDcisw, set << regs::kSetShift | way << regs::kWayShift);
        }
    }
    barrier();
    set_bits(regs::kCcr, regs::kDataCache);
    barrier();
    instruction_barrier();
}

void start_code_cache() noexcept {
    if ((read32(regs::kCcr) & regs::kCodeCache) != 0) {
        return;
    }
    barrier();
    instruction_barrier();
    write32(regs::kIciallu, 0);
    barrier();
    instruction_barrier();
    set_bits(regs::kCcr, regs::kCodeCache);
    barrier();
    instruction_barrier();
}

}  // namespace

bool start_memory(unsigned bank) noexcept {
    set_bits(regs::kAhb2enr, regs::kSram1Clock | regs::kSram2Clock | regs::kSram3Clock);
    (void)read32(regs::kAhb2enr);  // the clock is there two cycles later
    if (!protect(bank)) {
        return false;
    }
    start_data_cache();
    start_code_cache();
    set_bits(regs::kCcr, regs::kDivisionTrap);
    return true;
}

}  // namespace sc::stm32h743
