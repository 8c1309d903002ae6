// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "firmware/controller/controller.hpp"
#include "firmware/hal/io.hpp"

namespace sc::replay {

/// A controller whose memory was full of a pattern before it was constructed, and whose stack and outputs are before
/// each tick. A byte that the controller uses without having written it shows as a difference between two patterns.
class PaintedController {
public:
    /// Without a pattern the memory is zero and the stack is left alone.
    PaintedController(const MachineConfig& machine, std::uint32_t boot_id, std::optional<std::uint8_t> pattern);
    PaintedController(const PaintedController&) = delete;
    PaintedController& operator=(const PaintedController&) = delete;
    ~PaintedController();

    /// Once, before the first tick.
    void fit_key(const link::SealSecret& secret) { controller_->fit_key(secret); }
    /// servo_step, then `plan_units` of plan_step. The outputs are valid until the next tick.
    const ServoOutputs& tick(const ServoInputs& inputs, std::uint32_t plan_units);
    [[nodiscard]] const Controller& controller() const noexcept { return *controller_; }

private:
    struct Deleter {
        void operator()(std::byte* memory) const noexcept;
    };

    std::optional<std::uint8_t> pattern_;
    std::unique_ptr<std::byte, Deleter> memory_;
    Controller* controller_ = nullptr;
    std::unique_ptr<ServoOutputs> outputs_;
};

}  // namespace sc::replay
