// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an500/image/lock_step.hpp"

#include <atomic>

#include "boards/mps2_an500/image/board_ram.hpp"
#include "boards/mps2_an500/image/instruction_counter.hpp"
#include "boards/mps2_an500/image/stack.hpp"
#include "firmware/motion/path_motion.hpp"
#include "firmware/recording/io_image.hpp"

namespace sc::mps2_an500 {
namespace {

Controller* served = nullptr;
recording::StoredInputs stored;
ServoOutputs* produced = nullptr;

void servo_step() noexcept { served->servo_step(stored.inputs, *produced); }
void plan_step() noexcept { served->plan_step(motion::kUnitsPerTick); }

Answer tick(SharedRam& ram) noexcept {
    if (ram.inputs_size > ram.inputs.size() ||
        !recording::unpack(std::span<const std::uint8_t>(ram.inputs).first(ram.inputs_size), stored)) {
        return Answer::bad_inputs;
    }
    recording::clear(*produced);
    ram.servo_instructions = count_instructions(servo_step);
    ram.plan_instructions = count_instructions(plan_step);
    ram.first_fault = static_cast<std::uint32_t>(served->first_fault().fault);
    ram.outputs_size = static_cast<std::uint32_t>(recording::pack(*produced, ram.outputs));
    return ram.outputs_size == 0 ? Answer::bad_outputs : Answer::done;
}

std::uint32_t passes_wanted = 0;

/// loop_instructions_of() says how many: two loads, then two a pass. The return is not counted.
[[gnu::naked]] void known_loop() noexcept {
    asm volatile(
        "ldr r0, =%0\n"
        "ldr r0, [r0]\n"
        "1: subs r0, r0, #1\n"
        "bne 1b\n"
        "bx lr\n"
        ".ltorg\n" ::"i"(&passes_wanted));
}

void count_loops(SharedRam& ram) noexcept {
    for (std::size_t i = 0; i < kLoops; ++i) {
        passes_wanted = loop_passes(i);
        ram.loop_instructions[i] = count_instructions(known_loop);
    }
}

constexpr std::uint32_t kDeeperThanAnyStack = 0x1000'0000;

/// Needs a frame a call: the depth is read again after it.
[[gnu::noipa]] std::uint32_t exhaust_stack(std::uint32_t depth) noexcept {
    const volatile std::uint32_t kept = depth;
    return depth == kDeeperThanAnyStack ? 0 : exhaust_stack(depth + 1) + kept;
}

/// A core of QEMU that waits in a loop takes a whole core of the PC, which may be what the PC's side is waiting for.
constexpr std::uint32_t kPollsBeforeNap = 4000;

Answer serve(SharedRam& ram) noexcept {
    switch (static_cast<Request>(ram.command)) {
        case Request::tick: return tick(ram);
        case Request::measure_stack: ram.stack_used = stack_used(); return Answer::done;
        case Request::count_loops: count_loops(ram); return Answer::done;
        case Request::exhaust_stack: ram.stack_used = exhaust_stack(0); return Answer::done;
        case Request::fit_key:
            served->fit_key({ram.seal_key, ram.seal_entropy});
            ram.seal_key = {};
            return Answer::done;
        case Request::provoke_fault: asm volatile("udf #0"); return Answer::done;
    }
    return Answer::bad_request;
}

}  // namespace

void serve_lock_step(Controller& controller, ServoOutputs& outputs) noexcept {
    served = &controller;
    produced = &outputs;
    SharedRam& ram = shared_ram();
    const std::atomic_ref request(ram.request);
    const std::atomic_ref done(ram.done);
    ram.stack_used_at_start = stack_used();
    repaint_stack();
    start_instruction_counter();
    set_core_state(CoreState::ready);
    for (std::uint32_t served_requests = done.load(std::memory_order_relaxed);;) {
        for (std::uint32_t polls = 0; request.load(std::memory_order_acquire) == served_requests; ++polls) {
            if (polls >= kPollsBeforeNap) {
                nap();
            }
        }
        ram.answer = static_cast<std::uint32_t>(serve(ram));
        done.store(++served_requests, std::memory_order_release);
    }
}

}  // namespace sc::mps2_an500
