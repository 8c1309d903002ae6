// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/backup_ram.hpp"

#include <algorithm>

namespace sc::model {
namespace {

constexpr std::uint32_t kBkpramen = 0x10000000;
constexpr std::uint32_t kDbp = 0x0100;
constexpr std::uint32_t kBren = 0x01;
constexpr std::uint32_t kBrrdy = 0x00010000;

}  // namespace

const std::map<std::string, std::uint32_t> BackupRam::kMasks{
    {"RCC_AHB4ENR.BKPRAMEN", kBkpramen},
    {"PWR_CR1.DBP", kDbp},
    {"PWR_CR2.BREN", kBren},
    {"PWR_CR2.BRRDY", kBrrdy},
};

BackupRam::BackupRam(Machine& machine, Core& core) : machine_(machine), core_(core), lost_(kBytes / 4, false) {
    machine.attach(kClocks, 4, clocks_registers_);
    machine.attach(kPower, 0x40, power_);
    machine.attach(kRam, kBytes, cells_);
}

void BackupRam::power_cycle() {
    if (!regulator_ready()) {
        bytes_.fill(0xA5);
        lost_.assign(lost_.size(), true);
    }
    // The regulator's bit lies in the backup domain and stays; the access to it and the clock do not.
    clocks_ = 0;
    control1_ = 0;
}

bool BackupRam::whole() const {
    return std::ranges::none_of(lost_, [](bool lost) { return lost; });
}

bool BackupRam::regulator_ready() const {
    return regulator_ && regulator_ns >= 0 && machine_.now_ns() - regulator_on_ns_ >= regulator_ns;
}

std::uint32_t BackupRam::Clocks::read(std::uint32_t /*offset*/) { return ram_.clocks_; }

void BackupRam::Clocks::write(std::uint32_t /*offset*/, std::uint32_t value, unsigned /*bytes*/) {
    ram_.clocks_ = value;
}

std::uint32_t BackupRam::Power::read(std::uint32_t offset) {
    switch (offset) {
        case kPowerControl1: return ram_.control1_;
        case kPowerControl2: return (ram_.regulator_ ? kBren : 0U) | (ram_.regulator_ready() ? kBrrdy : 0U);
        default: ram_.machine_.violation("power: a register that is not modelled is read"); return 0;
    }
}

void BackupRam::Power::write(std::uint32_t offset, std::uint32_t value, unsigned /*bytes*/) {
    switch (offset) {
        case kPowerControl1: ram_.control1_ = ram_.access_stuck ? value & ~kDbp : value; break;
        case kPowerControl2:
            if ((ram_.control1_ & kDbp) == 0) {
                ram_.machine_.violation("power: CR2 is written while the backup domain is protected");
                return;
            }
            if ((value & kBren) != 0 && !ram_.regulator_) {
                ram_.regulator_on_ns_ = ram_.machine_.now_ns();
            }
            ram_.regulator_ = (value & kBren) != 0;
            break;
        default: ram_.machine_.violation("power: a register that is not modelled is written"); break;
    }
}

std::uint32_t BackupRam::Cells::read(std::uint32_t offset) {
    if ((ram_.clocks_ & kBkpramen) == 0) {
        ram_.machine_.violation("backup RAM: read without its clock");
        return 0;
    }
    if (ram_.lost_.at(offset / 4)) {
        ram_.core_.bus_fault("a word of the backup RAM that ECC cannot put right");
        return 0;
    }
    std::uint32_t value = 0;
    for (std::uint32_t i = 0; i < 4; ++i) {
        value |= std::uint32_t{ram_.bytes_.at(offset + i)} << (8U * i);
    }
    return value;
}

void BackupRam::Cells::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if ((ram_.clocks_ & kBkpramen) == 0 || (ram_.control1_ & kDbp) == 0) {
        ram_.machine_.violation("backup RAM: written without its clock, or while it is protected");
        return;
    }
    if (bytes != 4) {
        ram_.machine_.violation("backup RAM: a part of a word reads the word before");
        return;
    }
    ram_.lost_.at(offset / 4) = false;
    for (std::uint32_t i = 0; i < 4; ++i) {
        ram_.bytes_.at(offset + i) = static_cast<std::uint8_t>(value >> (8U * i));
    }
}

}  // namespace sc::model
