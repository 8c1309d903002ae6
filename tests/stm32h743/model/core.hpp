// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "tests/stm32h743/model/machine.hpp"

/// What the processor does with a load that fails, and how a line of its data cache is forgotten (architecture
/// reference manual of ARMv7-M). FAULTMASK is not seen on a PC: with BFHFNMIGN a failing load is taken as masked.

namespace sc::model {

class Core final : public Peripheral {
public:
    static constexpr std::uint32_t kBase = 0xE000ED00;
    static constexpr std::uint32_t kConfiguration = 0x14;
    static constexpr std::uint32_t kFaults = 0x28;
    static constexpr std::uint32_t kForgetLine = 0x25C;
    /// REGISTER.FIELD.
    static const std::map<std::string, std::uint32_t> kMasks;

    /// `forget`: called with the address of a line that the cache shall forget.
    Core(Machine& machine, std::function<void(std::uint32_t)> forget);
    [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
    void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;

    /// A load has failed.
    void bus_fault(const std::string& why);
    void reset();
    /// As after a start.
    [[nodiscard]] bool clean() const { return configuration_ == kStart && faults_ == 0; }

private:
    static constexpr std::uint32_t kStart = 0x00040200;
    Machine& machine_;
    std::function<void(std::uint32_t)> forget_;
    std::uint32_t configuration_ = kStart;
    std::uint32_t faults_ = 0;
};

}  // namespace sc::model
