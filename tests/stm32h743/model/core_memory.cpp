// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/core_memory.hpp"

namespace sc::model {

using namespace core_memory_fields;

namespace {

std::uint32_t get(std::uint32_t word, const Field& one) { return (word & one.mask()) >> one.first; }

}  // namespace

CoreMemory::CoreMemory(Machine& machine, unsigned regions) : machine_(machine), regions_(regions) {
    machine.attach(kScb, 0x300, *this);
}

void CoreMemory::preset_by_boot_loader() {
    control_ = kEnable.mask() | kDefaultMap.mask();
    held_.back() = {0, kRegionEnable.mask() | kSize.mask() | 3U << kAp.first | kC.mask() | kB.mask()};
    ccr_ |= kDataCache.mask() | kCodeCache.mask();
}

bool CoreMemory::holds(const Region& region, std::uint32_t address) const {
    const unsigned size = get(region.attributes, kSize) + 1;
    return get(region.attributes, kRegionEnable) != 0 && (size == 32 || address >> size == region.base >> size);
}

Allowed CoreMemory::by_architecture(std::uint32_t address) {
    switch (address >> 29U) {
        case 0:  // code
            return {.read = true, .write = true, .execute = true, .cached = true, .written_late = false};
        case 1:  // SRAM
        case 3:  // outside
            return {.read = true, .write = true, .execute = true, .cached = true, .written_late = true};
        case 4: return {.read = true, .write = true, .execute = true, .cached = true, .written_late = false};
        default:  // devices
            return {.read = true, .write = true, .execute = false, .cached = false, .written_late = false};
    }
}

Allowed CoreMemory::allowed(std::uint32_t address) const {
    if (get(control_, kEnable) == 0) {
        return by_architecture(address);
    }
    for (unsigned i = regions_; i-- > 0;) {
        const Region& region = held_.at(i);
        if (!holds(region, address)) {
            continue;
        }
        const std::uint32_t ap = get(region.attributes, kAp);
        const bool read = ap != 0;
        const bool write = ap >= 1 && ap <= 3;
        const bool cached = get(region.attributes, kC) != 0;
        return {.read = read,
                .write = write,
                .execute = read && get(region.attributes, kXn) == 0,
                .cached = cached,
                .written_late = cached && get(region.attributes, kB) != 0};
    }
    return get(control_, kDefaultMap) != 0 ? by_architecture(address) : Allowed{};
}

std::uint32_t CoreMemory::read(std::uint32_t offset) {
    switch (kScb + offset) {
        case kRegions.address: return regions_ << kRegions.first;
        case kEnable.address: return control_;
        case kNumber.address: return number_;
        case kDataCache.address: return ccr_;
        case kSelect.address: return select_;
        case kBase.address: return held_.at(number_).base | number_;
        case kSize.address: return held_.at(number_).attributes;
        default: say("a register that is not modelled or cannot be read"); return 0;
    }
}

void CoreMemory::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (bytes != 4) {
        return say("written by parts");
    }
    switch (kScb + offset) {
        case kEnable.address:
            if ((value & ~7U) != 0) {
                say("a reserved bit of CTRL");
            }
            control_ = value;
            return;
        case kNumber.address:
            if (value >= regions_) {
                return say("a region that is not there");
            }
            number_ = value;
            return;
        case kBase.address:
            if (get(control_, kEnable) != 0) {
                say("a region moves while protection is on");
            }
            if ((value & ~kBase.mask()) != 0) {
                say("RBAR names another region");
            }
            held_.at(number_).base = value;
            return;
        case kSize.address: return write_region(value);
        case kDataCache.address: return write_ccr(value);
        case kSelect.address: select_ = value; return;
        case kInvalidateCode.address: code_invalid_ = true; return;
        case kSet.address:
            if (select_ != 0) {
                say("a line of another cache");
            }
            if ((ccr_ & kDataCache.mask()) != 0) {
                say("a line of the data cache is lost that may hold what was written");
            }
            invalid_.set(get(value, kSet) * 4 + get(value, kWay));
            return;
        default: say("a register that is not modelled");
    }
}

void CoreMemory::write_region(std::uint32_t attributes) {
    if (get(control_, kEnable) != 0) {
        say("a region changes while protection is on");
    }
    constexpr std::uint32_t kKnown = kRegionEnable.mask() | kSize.mask() | kSubregions.mask() | kB.mask() | kC.mask() |
                                     kS.mask() | kTex.mask() | kAp.mask() | kXn.mask();
    if ((attributes & ~kKnown) != 0) {
        say("a reserved bit of RASR");
    }
    if (get(attributes, kSubregions) != 0) {
        say("subregions are not modelled");
    }
    held_.at(number_).attributes = attributes;
    if (get(attributes, kRegionEnable) == 0) {
        return;
    }
    const unsigned size = get(attributes, kSize) + 1;
    if (size < 5 || (size < 32 && (held_.at(number_).base & ((1U << size) - 1U)) != 0)) {
        say("a region does not begin at a multiple of its size");
    }
    const std::uint32_t type = get(attributes, kTex) << 2U | get(attributes, kC) << 1U | get(attributes, kB);
    if (type != 0 && type != 1 && type != 2 && type != 3 && type != 4 && type != 7 && type != 8) {
        say("a memory type that is reserved");
    }
    const std::uint32_t ap = get(attributes, kAp);
    if (ap == 4 || ap == 7) {
        say("a permission that is reserved");
    }
}

void CoreMemory::write_ccr(std::uint32_t value) {
    const std::uint32_t risen = value & ~ccr_;
    if ((risen & kDataCache.mask()) != 0) {
        if (!invalid_.all()) {
            say("the data cache starts with lines that were not invalidated");
        }
        if (get(control_, kEnable) == 0) {
            say("the data cache starts before the memory of DMA is kept out of it");
        }
    }
    if ((risen & kCodeCache.mask()) != 0 && !code_invalid_) {
        say("the code cache starts with what it had");
    }
    ccr_ = value;
}

}  // namespace sc::model
