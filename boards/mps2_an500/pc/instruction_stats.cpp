// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an500/pc/instruction_stats.hpp"

namespace sc::mps2_an500 {
namespace {

void raise(sim::InstructionMax& most, std::uint64_t count, std::int64_t tick) {
    if (count > most.count) {
        most = {count, tick};
    }
}

}  // namespace

void add(sim::InstructionFigures& figures, const TickCost& cost, std::int64_t tick) {
    raise(figures.servo, cost.servo, tick);
    raise(figures.plan, cost.plan, tick);
    raise(figures.tick, std::uint64_t{cost.servo} + cost.plan, tick);
    figures.servo_total += cost.servo;
    figures.plan_total += cost.plan;
    ++figures.ticks;
}

}  // namespace sc::mps2_an500
