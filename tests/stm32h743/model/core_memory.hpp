// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bitset>
#include <cstdint>

#include "tests/stm32h743/model/clock_tree.hpp"

/// The core's memory protection and caches: what an access to an address may do, by the registers. Numbers:
/// tests/data/stm32h743/core_memory.csv.

namespace sc::model {

namespace core_memory_fields {

inline constexpr std::uint32_t kScb = 0xE000ED00;
inline constexpr Field kDivisionTrap{"SCB_CCR", "DIV_0_TRP", kScb + 0x14, 4, 1};
inline constexpr Field kDataCache{"SCB_CCR", "DC", kScb + 0x14, 16, 1};
inline constexpr Field kCodeCache{"SCB_CCR", "IC", kScb + 0x14, 17, 1};
inline constexpr Field kSelect{"SCB_CSSELR", "CSSELR", kScb + 0x84, 0, 4};
inline constexpr Field kInvalidateCode{"SCB_ICIALLU", "ALL", kScb + 0x250, 0, 32};
inline constexpr Field kSet{"SCB_DCISW", "SET", kScb + 0x260, 5, 7};
inline constexpr Field kWay{"SCB_DCISW", "WAY", kScb + 0x260, 30, 2};
inline constexpr Field kRegions{"MPU_TYPE", "DREGION", kScb + 0x90, 8, 8};
inline constexpr Field kEnable{"MPU_CTRL", "ENABLE", kScb + 0x94, 0, 1};
inline constexpr Field kDefaultMap{"MPU_CTRL", "PRIVDEFENA", kScb + 0x94, 2, 1};
inline constexpr Field kNumber{"MPU_RNR", "REGION", kScb + 0x98, 0, 8};
inline constexpr Field kBase{"MPU_RBAR", "ADDR", kScb + 0x9C, 5, 27};
inline constexpr Field kRegionEnable{"MPU_RASR", "ENABLE", kScb + 0xA0, 0, 1};
inline constexpr Field kSize{"MPU_RASR", "SIZE", kScb + 0xA0, 1, 5};
inline constexpr Field kSubregions{"MPU_RASR", "SRD", kScb + 0xA0, 8, 8};
inline constexpr Field kB{"MPU_RASR", "B", kScb + 0xA0, 16, 1};
inline constexpr Field kC{"MPU_RASR", "C", kScb + 0xA0, 17, 1};
inline constexpr Field kS{"MPU_RASR", "S", kScb + 0xA0, 18, 1};
inline constexpr Field kTex{"MPU_RASR", "TEX", kScb + 0xA0, 19, 3};
inline constexpr Field kAp{"MPU_RASR", "AP", kScb + 0xA0, 24, 3};
inline constexpr Field kXn{"MPU_RASR", "XN", kScb + 0xA0, 28, 1};
inline constexpr std::array kAll{kDivisionTrap,
                                 kDataCache,
                                 kCodeCache,
                                 kSelect,
                                 kInvalidateCode,
                                 kSet,
                                 kWay,
                                 kRegions,
                                 kEnable,
                                 kDefaultMap,
                                 kNumber,
                                 kBase,
                                 kB,
                                 kC,
                                 kS,
                                 kSize,
                                 kRegionEnable,
                                 kTex,
                                 kSubregions,
                                 kAp,
                                 kXn};

}  // namespace core_memory_fields

/// Of an access by privileged code.
struct Allowed {
    bool read = false;
    bool write = false;
    bool execute = false;
    bool cached = false;        ///< a DMA does not see what was written, or writes past what is cached
    bool written_late = false;  ///< with a cache: write back
    bool operator==(const Allowed&) const = default;
};

class CoreMemory : public Peripheral {
public:
    explicit CoreMemory(Machine& machine, unsigned regions = 16);
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
    [[nodiscard]] Allowed allowed(std::uint32_t address) const;
    [[nodiscard]] bool caches_on() const { return (ccr_ >> 16U & 3U) == 3; }
    [[nodiscard]] bool division_traps() const { return (ccr_ & core_memory_fields::kDivisionTrap.mask()) != 0; }
    /// As a boot loader leaves it: protection on, the last region opens everything, caches on.
    void preset_by_boot_loader();

private:
    struct Region {
        std::uint32_t base = 0;
        std::uint32_t attributes = 0;
    };
    void write_region(std::uint32_t attributes);
    void write_ccr(std::uint32_t value);
    [[nodiscard]] bool holds(const Region& region, std::uint32_t address) const;
    [[nodiscard]] static Allowed by_architecture(std::uint32_t address);
    void say(const std::string& what) { machine_.violation("core memory: " + what); }

    Machine& machine_;
    std::array<Region, 16> held_{};
    std::bitset<512> invalid_;  ///< lines of the data cache that were invalidated
    unsigned regions_;
    std::uint32_t control_ = 0;
    std::uint32_t number_ = 0;
    std::uint32_t ccr_ = 0x0004'0200;
    std::uint32_t select_ = 0;
    bool code_invalid_ = false;
};

}  // namespace sc::model
