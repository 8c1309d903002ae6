// SPDX-License-Identifier: Apache-2.0
#include "boards/replay/painted_controller.hpp"

#include <array>
#include <new>

#include "firmware/recording/io_image.hpp"

namespace sc::replay {
namespace {

constexpr std::align_val_t kAlignment{alignof(Controller)};
/// Deeper than any step of the controller goes.
constexpr std::size_t kStackBytes = 65'536;

/// Memory that the compiler does not know to be dead: its paint must not be taken away as needless.
void paint(void* memory, std::size_t bytes, std::uint8_t pattern) {
    auto* bytes_of = static_cast<volatile std::uint64_t*>(memory);
    const std::uint64_t word = 0x0101'0101'0101'0101U * pattern;
    for (std::size_t i = 0; i < bytes / sizeof(word); ++i) {
        bytes_of[i] = word;
    }
}

[[gnu::noinline]] void paint_stack(std::uint8_t pattern) {
    alignas(std::uint64_t) std::array<std::uint8_t, kStackBytes> below;
    paint(below.data(), below.size(), pattern);
}

}  // namespace

void PaintedController::Deleter::operator()(std::byte* memory) const noexcept { ::operator delete(memory, kAlignment); }

PaintedController::PaintedController(const MachineConfig& machine, std::uint32_t boot_id,
                                     std::optional<std::uint8_t> pattern)
    : pattern_(pattern),
      memory_(static_cast<std::byte*>(::operator new(sizeof(Controller), kAlignment))),
      outputs_(std::make_unique<ServoOutputs>()) {
    paint(memory_.get(), sizeof(Controller), pattern_.value_or(0));
    if (pattern_) {
        paint_stack(*pattern_);
    }
    controller_ = new (memory_.get()) Controller(machine, boot_id);
}

PaintedController::~PaintedController() { controller_->~Controller(); }

const ServoOutputs& PaintedController::tick(const ServoInputs& inputs, std::uint32_t plan_units) {
    if (pattern_) {
        // Only what the controller may not rely on: what it appends to starts empty on every board.
        paint(&outputs_->set_point, sizeof(outputs_->set_point), *pattern_);
        paint(&outputs_->galvo, sizeof(outputs_->galvo), *pattern_);
        paint_stack(*pattern_);
    }
    recording::clear(*outputs_);
    controller_->servo_step(inputs, *outputs_);
    controller_->plan_step(plan_units);
    return *outputs_;
}

}  // namespace sc::replay
