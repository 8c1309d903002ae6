// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "boards/stm32h743/link/fdcan.hpp"
#include "tests/stm32h743/model/can_wire.hpp"
#include "tests/stm32h743/model/fdcan.hpp"
#include "tests/stm32h743/model/machine.hpp"
#include "tests/stm32h743/model/register_words.hpp"

namespace sc::stm32h743::test {

/// The chip's two FDCANs on one bus.
struct CanCell {
    CanCell() { machine.attach(model::rcc::kBase, model::rcc::kSize, clocks); }

    void pass_us(std::int64_t us) { machine.advance_to(machine.now_ns() + 1000 * us); }

    model::Machine machine;
    model::RegisterWords clocks;
    model::FdcanRam ram{machine, clocks};
    model::CanWire wire{machine};
    model::FdcanModel one{machine, clocks, ram, wire, model::FdcanModel::kFdcan1};
    model::FdcanModel two{machine, clocks, ram, wire, model::FdcanModel::kFdcan2};
};

inline CanFrame frame_of(std::uint32_t id, std::uint8_t size, std::uint8_t seed = 1) {
    CanFrame frame;
    frame.id = id;
    frame.size = size;
    for (std::uint8_t i = 0; i < size; ++i) {
        frame.data[i] = static_cast<std::uint8_t>(seed * 31U + i * 7U + 1U);
    }
    return frame;
}

inline CanFrame fd_frame_of(std::uint32_t id, std::uint8_t size, bool fast) {
    CanFrame frame = frame_of(id, size);
    frame.fd = true;
    frame.fast = fast;
    return frame;
}

/// As `frame`, whatever its age.
inline bool same(CanFrame heard, const CanFrame& frame) {
    heard.age_bits = frame.age_bits;
    return heard == frame;
}

/// Two FD ports in the message RAM.
inline constexpr FdcanSettings kFdOne{fdcan::kFdcan1, 0, 32, 16, true, kNominal1M, kData5M};
inline constexpr FdcanSettings kFdTwo{fdcan::kFdcan2, kFdOne.end(), 32, 16, true, kNominal1M, kData5M};

}  // namespace sc::stm32h743::test
