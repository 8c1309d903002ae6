// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/core_faults.hpp"

namespace sc::model {

using namespace fault_fields;

BackupRam::BackupRam(Machine& machine, ClockTree& tree) : machine_(machine), tree_(tree) {
    machine.attach(kBackupRam, kBackupBytes, *this);
}

std::uint32_t BackupRam::read(std::uint32_t offset) {
    if (!tree_.on(clock_fields::kBackupRamEn) || !tree_.settled(clock_fields::kBackupRamEn)) {
        machine_.violation("backup RAM is read without its clock, or before it has settled");
        return 0;
    }
    return waiting_at_ == offset ? waiting_ : words_.at(offset / 4);
}

void BackupRam::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (!tree_.on(clock_fields::kBackupRamEn) || !tree_.settled(clock_fields::kBackupRamEn)) {
        return machine_.violation("backup RAM is written without its clock, or before it has settled");
    }
    if (!tree_.on(clock_fields::kBackupUnlock)) {
        return machine_.violation("backup RAM is written under its lock");
    }
    if (bytes != 4) {
        return machine_.violation("backup RAM is written by parts of its words");
    }
    if (left_ == 0) {
        return;
    }
    --left_;
    flush();
    waiting_at_ = offset;
    waiting_ = value;
}

void BackupRam::flush() {
    if (waiting_at_) {
        words_.at(*waiting_at_ / 4) = waiting_;
    }
    waiting_at_.reset();
}

void BackupRam::reset() {
    waiting_at_.reset();
    left_ = ~0U;
    tree_.preset(clock_fields::kBackupRamEn, 0);
    tree_.preset(clock_fields::kBackupUnlock, 0);
}

OutputPort::OutputPort(Machine& machine, ClockTree& tree, std::uint32_t base, const Field& clock)
    : machine_(machine), tree_(tree), clock_(clock) {
    machine.attach(base, 0x400, *this);
}

void OutputPort::preset(std::uint32_t modes, std::uint32_t outputs) {
    modes_ = modes;
    outputs_ = outputs;
}

std::uint32_t OutputPort::levels() const {
    std::uint32_t high = 0;
    for (unsigned pin = 0; pin < 16; ++pin) {
        const std::uint32_t mode = (modes_ >> (2 * pin)) & 3U;
        const std::uint32_t from = mode == 1 ? outputs_ : mode == 2 ? driven_ : 0U;
        high |= from & (1U << pin);
    }
    return high;
}

std::uint32_t OutputPort::read(std::uint32_t offset) {
    if (!tree_.on(clock_) || !tree_.settled(clock_)) {
        machine_.violation("a port is read without its clock, or before it has settled");
        return 0;
    }
    return offset == 0x00 ? modes_ : offset == 0x14 ? outputs_ : 0;
}

void OutputPort::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (!tree_.on(clock_) || !tree_.settled(clock_)) {
        return machine_.violation("a port is written without its clock, or before it has settled");
    }
    const std::uint32_t before = levels();
    if (offset == 0x00 && bytes == 4) {
        modes_ = value;
    } else if (offset == 0x18 && bytes == 4) {
        outputs_ = (outputs_ & ~(value >> 16U)) | (value & 0xFFFFU);
    } else {
        machine_.violation("a register of a port that is not modelled");
    }
    if ((levels() & ~before & watched_) != 0) {
        machine_.violation("an output rises on the way to its safe level");
    }
}

CoreStatus::CoreStatus(Machine& machine) : machine_(machine) { machine.attach(kScb, 0x300, *this); }

std::uint32_t CoreStatus::read(std::uint32_t offset) { return words_[offset]; }

void CoreStatus::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (bytes != 4) {
        return machine_.violation("a register of the core is written by parts");
    }
    switch (kScb + offset) {
        case kResetRequest.address:
            if ((value & kVectKey.mask()) != 0x05FA'0000) {
                return machine_.violation("AIRCR is written without its key");
            }
            reset_requested_ = reset_requested_ || (value & kResetRequest.mask()) != 0;
            return;
        case kMemFaultEna.address:
            if (((value ^ words_[offset]) & ~(kMemFaultEna.mask() | kBusFaultEna.mask() | kUsgFaultEna.mask())) != 0) {
                machine_.violation("SHCSR: an active or pending bit changes");
            }
            words_[offset] = value;
            return;
        default: machine_.violation("the core's fault status is written");
    }
}

MainOutput::MainOutput(Machine& machine, ClockTree& tree) : machine_(machine), tree_(tree) {
    machine.attach(kTim1, 0x48, *this);
}

void MainOutput::check() {
    if (!tree_.on(clock_fields::kTim1En)) {
        machine_.violation("TIM1 is used without its clock");
    }
}

std::uint32_t MainOutput::read(std::uint32_t offset) {
    check();
    return offset == 0x44 ? bdtr_ : 0;
}

void MainOutput::write(std::uint32_t offset, std::uint32_t value, unsigned /*bytes*/) {
    check();
    if (offset != 0x44) {
        return machine_.violation("a register of TIM1 that a fault has nothing to do with");
    }
    bdtr_ = value;
}

}  // namespace sc::model
