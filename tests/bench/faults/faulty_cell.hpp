// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/bench/faults/bench_board.hpp"
#include "tests/bench/faults/pins.hpp"
#include "tests/sim/firmware/controller/cell_rig.hpp"

namespace sc::faults {

/// What an instant of the undisturbed job looks like.
struct Instant {
    std::string_view state;
    double speed = 0.0;         ///< of X, Y, Z as commanded, mm/s
    double acceleration = 0.0;  ///< of that speed, mm/s²
    double turn = 0.0;          ///< of C, degrees/s
    double climb = 0.0;         ///< of Z, mm/s
    bool mirrors = false;       ///< they move
};

/// The simulated cell with its host, and all that is seen of it from outside.
class FaultyCell {
public:
    FaultyCell();

    test::CellRig& rig() { return *rig_; }
    /// For the oracle: the host is about to ask for the guide laser.
    void guide_asked() { trace_.lines.push_back({now_ns(), Line::guide_asked, true}); }
    BoardTrouble& board() { return board_->trouble; }
    [[nodiscard]] std::int64_t now_ns() const { return rig_->cell().now_ns(); }
    [[nodiscard]] std::string_view state() const { return name_of(rig_->state()); }
    Trace& trace() { return trace_; }
    [[nodiscard]] const std::vector<Instant>& instants() const { return instants_; }

    /// A line of a fault script that falls due now + `after_ns`.
    void inject(const std::string& what, std::int64_t after_ns);
    /// Sends a command; its answer, and when it came, stand in the trace too.
    bool ask(link::Verb verb, std::string_view name, bool cause_present);
    void begin_job();
    /// From now to 0.4 µs before the light of a trigger that is on its way, ns.
    [[nodiscard]] std::int64_t before_trigger() const;
    static std::vector<Item> job();

private:
    void see_tick();

    std::unique_ptr<test::CellRig> rig_;
    BenchBoard* board_ = nullptr;
    Trace trace_;
    std::vector<Instant> instants_;
    std::vector<int> level_ = std::vector<int>(8, -1);
    std::size_t burns_seen_ = 0;
};

}  // namespace sc::faults
