// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/pendant/whb04b.hpp"
#include "shared/machine/machine.hpp"
#include "shared/units/time.hpp"

/// What a person wants who turns and presses a pendant, and what must not be done although it was pressed. No I/O, no
/// clock: told what came and when, it says what to do.

namespace sc::host::pendant {

/// What a detent moves, for each place of the feed knob: micrometres, or thousandths of a degree. 0: nothing.
struct StepTable {
    /// Of 0.001, 0.01, 0.1, 1, 60 %, 100 %, Lead.
    std::array<double, 7> um{1.0, 10.0, 100.0, 1000.0, 5.0, 0.0, 0.0};

    /// Metres or degrees; 0 where the knob has no step.
    [[nodiscard]] double step(FeedKnob knob, bool turn) const;
    /// "0.001: 1 um, 0.01: 10 um, ... 60 %: 5 um".
    [[nodiscard]] std::string text() const;
};
inline constexpr double kLargestStepUm = 1000.0;
/// Five steps or seven, micrometres, from what a person gives; each 0 or 0.1..1000. Throws InputError.
[[nodiscard]] StepTable step_table(std::span<const double> um);

struct ControlOptions {
    StepTable steps{};
    bool hold_fn = false;               ///< the wheel counts only while Fn is held, and a move ends when it is let go
    Nanoseconds dead_man{500'000'000};  ///< after the last detent nothing moves
};

enum class WishKind : std::uint8_t {
    jog,
    stop,      ///< of whatever moves, at once
    override,  ///< feed of paths
    start_pause,
    reset,
    take,  ///< Probe-Z: this place
    skip,  ///< Safe-Z
    undo,  ///< W-HOME
    shown  ///< axis or step have changed: show them
};

struct Wish {
    WishKind kind = WishKind::shown;
    Axis axis = Axis::x;
    double distance = 0.0;      ///< metres; C: degrees
    std::uint8_t percent = 0;   ///< of the override
    bool disarmed = false;      ///< of a stop: the wheel is dead until the axis knob is turned
    const char* why = nullptr;  ///< of a stop

    friend bool operator==(const Wish&, const Wish&) = default;
};

/// Detents of the wheel, by what became of them. Each is in `moved` or in one of the others.
struct ControlCounters {
    std::uint64_t reports = 0;
    std::uint64_t malformed = 0;  ///< reports that were none
    std::uint64_t moved = 0;
    std::uint64_t busy = 0;      ///< while the one before was still moving: not kept for later
    std::uint64_t late = 0;      ///< read too long after they were turned
    std::uint64_t beyond = 0;    ///< over the cap of one report
    std::uint64_t unarmed = 0;   ///< the first report, knob off, no step, Fn not held, or stopped before
    std::uint64_t unproven = 0;  ///< wrong checksum
    std::uint64_t stops = 0;
    std::uint64_t unplugs = 0;
};

/// What the cell does meanwhile.
struct CellView {
    bool moving = false;  ///< a jog is under way
    std::uint8_t override_percent = 100;
};

class PendantControl {
public:
    static constexpr int kMostDetents = 10;             ///< of one report
    static constexpr double kMost = 2e-3;               ///< metres that one report may ask for
    static constexpr double kMostTurn = 2.0;            ///< degrees
    static constexpr Nanoseconds kOldest{200'000'000};  ///< a report that waited longer moves nothing

    explicit PendantControl(const ControlOptions& options = {}) : options_(options) {}

    void plugged();
    [[nodiscard]] std::vector<Wish> unplugged(const CellView& cell);
    /// Bytes of a report that was read `age` ago.
    [[nodiscard]] std::vector<Wish> take(std::span<const std::uint8_t> bytes, HostTime now, Nanoseconds age,
                                         const CellView& cell);
    /// To be called all along: the dead-man's switch.
    [[nodiscard]] std::vector<Wish> pass(HostTime now, const CellView& cell);

    [[nodiscard]] const ControlCounters& counters() const { return counters_; }
    [[nodiscard]] bool connected() const { return connected_; }
    [[nodiscard]] bool armed() const { return connected_ && last_ && !must_turn_; }
    /// The wheel is dead until the axis knob is turned.
    [[nodiscard]] bool must_turn() const { return must_turn_; }
    /// The axis that the wheel moves; nothing when the knob is off or names none.
    [[nodiscard]] std::optional<Axis> axis() const;
    /// Of a detent, metres or degrees; 0 without axis or step.
    [[nodiscard]] double step() const;

private:
    void stop(std::vector<Wish>& out, bool disarm, const char* why);
    void knobs(const Report& report, const CellView& cell, std::vector<Wish>& out);
    void keys(const Report& report, const CellView& cell, std::vector<Wish>& out);
    void wheel(const Report& report, HostTime now, Nanoseconds age, bool known, const CellView& cell,
               std::vector<Wish>& out);

    ControlOptions options_;
    ControlCounters counters_;
    bool connected_ = false;
    std::optional<Report> last_;
    bool must_turn_ = false;  ///< the axis knob, before the wheel counts again
    bool stopping_ = false;   ///< asked for already, for this move
    HostTime turned_{};
};

}  // namespace sc::host::pendant
