// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/core.hpp"

#include <utility>

namespace sc::model {
namespace {

constexpr std::uint32_t kIgnoreFaults = 0x100;
constexpr std::uint32_t kPreciseFault = 0x0200;
constexpr std::uint32_t kFaultAddress = 0x8000;

}  // namespace

const std::map<std::string, std::uint32_t> Core::kMasks{
    {"SCB_CCR.BFHFNMIGN", kIgnoreFaults},
    {"SCB_CFSR.PRECISERR", kPreciseFault},
    {"SCB_CFSR.BFARVALID", kFaultAddress},
};

Core::Core(Machine& machine, std::function<void(std::uint32_t)> forget)
    : machine_(machine), forget_(std::move(forget)) {
    machine.attach(kBase, 0x300, *this);
}

void Core::reset() {
    configuration_ = kStart;
    faults_ = 0;
}

std::uint32_t Core::read(std::uint32_t offset) {
    switch (offset) {
        case kConfiguration: return configuration_;
        case kFaults: return faults_;
        default: machine_.violation("core: a register that is not modelled is read"); return 0;
    }
}

void Core::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (bytes != 4) {
        machine_.violation("core: registers are words");
    }
    switch (offset) {
        case kConfiguration: configuration_ = value; break;
        case kFaults: faults_ &= ~value; break;
        case kForgetLine: forget_(value); break;
        default: machine_.violation("core: a register that is not modelled is written"); break;
    }
}

void Core::bus_fault(const std::string& why) {
    faults_ |= kPreciseFault | kFaultAddress;
    if ((configuration_ & kIgnoreFaults) == 0) {
        machine_.violation("core: bus fault by " + why);
    }
}

}  // namespace sc::model
