// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/faults/bench_board.hpp"

#include <cfenv>
#include <utility>

namespace sc::faults {
namespace {

constexpr std::uint16_t kPlaceReport = 0x180;  ///< TPDO1: status word, place
constexpr std::uint16_t kTarget = 0x200;       ///< RPDO1: control word, target
constexpr int kStartTicks = 50;                ///< of a controller that starts; its pins are at rest

/// Adds to the 32-bit number behind the status or control word.
void shift(DriveFrame& frame, std::int32_t counts) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        value |= std::uint32_t{frame.data[2 + i]} << (8 * i);
    }
    value += static_cast<std::uint32_t>(counts);
    for (std::size_t i = 0; i < 4; ++i) {
        frame.data[2 + i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
}

}  // namespace

BenchBoard::BenchBoard(const MachineConfig& machine, std::uint32_t boot_id, RetainedMemory* retained)
    : machine_(machine),
      boot_id_(boot_id),
      retained_(retained),
      controller_(std::make_unique<Controller>(machine, boot_id, retained)) {}

std::span<const DriveFrame> BenchBoard::received(std::span<const DriveFrame> frames) {
    frames_.clear();
    if (trouble.bus_off) {
        return frames_;
    }
    frames_.assign(frames.begin(), frames.end());
    for (DriveFrame& frame : frames_) {
        if (trouble.jump_axis >= 0 && frame.id == kPlaceReport + trouble.jump_axis + 1) {
            shift(frame, trouble.off_counts);
        }
    }
    return frames_;
}

void BenchBoard::send(ServoOutputs& outputs) const {
    if (trouble.bus_off) {
        outputs.drive_tx_size = 0;
    }
    for (std::size_t i = 0; i < outputs.drive_tx_size; ++i) {
        if (trouble.shoved_axis >= 0 && outputs.drive_tx[i].id == kTarget + trouble.shoved_axis + 1) {
            shift(outputs.drive_tx[i], trouble.off_counts);
        }
    }
}

void BenchBoard::tick(const ServoInputs& inputs, ServoOutputs& outputs) {
    if (std::exchange(trouble.reset, false)) {
        controller_ = std::make_unique<Controller>(machine_, ++boot_id_, retained_);
        dead_ticks_ = kStartTicks;
    }
    if (dead_ticks_ > 0 || trouble.missed_ticks > 0) {
        (dead_ticks_ > 0 ? dead_ticks_ : trouble.missed_ticks) -= 1;
        outputs.cancel_laser = true;
        return;
    }
    ServoInputs seen = inputs;
    seen.drive_rx = received(inputs.drive_rx);
    const int mode = std::fegetround();
    if (trouble.rounding) {
        std::fesetround(FE_UPWARD);
    }
    controller_->servo_step(seen, outputs);
    if (!trouble.no_plan) {
        controller_->plan_step(motion::kUnitsPerTick);
    }
    std::fesetround(mode);
    send(outputs);
}

}  // namespace sc::faults
