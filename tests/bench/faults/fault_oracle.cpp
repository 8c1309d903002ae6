// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/faults/fault_oracle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

namespace sc::faults {
namespace {

// shared/design.md, "laser off, from input edge to last pulse".
constexpr std::int64_t kLineNs = 1'000;
constexpr std::int64_t kGuardNs = 110'000;
constexpr std::int64_t kTickPathNs = 1'010'000;
constexpr std::int64_t kTickNs = 1'000'000;
constexpr std::int64_t kCancelNs = 10'000;  ///< from the tick to the shut gate
// docs/states.md and the type-D sequence.
constexpr std::int64_t kWarningNs = 500'000'000;
constexpr std::int64_t kOscillatorWaitNs = 8'000'000;
// The reference cell's axes, X, Y, Z in mm and C in degrees, with 1 % for what a sample shows.
constexpr std::array<double, 4> kAcceleration{5'050.0, 5'050.0, 5'050.0, 181.8};
constexpr std::array<double, 4> kAtRest{0.3, 0.3, 0.3, 0.1};  ///< mm/s, degrees/s
// From full speed at full jerk: v / a + a / j = 65 ms (C: 350 ms), then the drives' lag.
constexpr std::int64_t kStopNs = 150'000'000;
constexpr std::int64_t kTurnStopNs = 450'000'000;
// Light off the undisturbed job's: noise of what is simulated; with an axis that is not where it says, its window of
// 0.2 mm and the way until it is believed.
constexpr double kOffPathMm = 0.02;
constexpr double kOffPathAxisMm = 0.5;
// A drive that is told a wrong target runs at its limit of 300 mm/s for a drive cycle and a tick more.
constexpr double kOffPathShovedMm = 1.1;

using Names = std::span<const std::string_view>;
constexpr std::array<std::string_view, 7> kLit{"arming",   "armed", "running",  "marking",
                                               "stopping", "held",  "held_link"};
constexpr std::array<std::string_view, 6> kPowered{"enabling", "idle",       "homing",
                                                   "jogging",  "previewing", "preview_stopping"};
constexpr std::array<std::string_view, 4> kPathStates{"running", "marking", "stopping", "previewing"};

bool among(Names names, std::string_view name) { return std::ranges::find(names, name) != names.end(); }
bool lit(std::string_view state) { return among(kLit, state); }
bool powered(std::string_view state) { return lit(state) || among(kPowered, state); }

/// Where a fault must be seen.
enum class Seen : std::uint8_t { lit, powered, always, moving, own };

struct Rule {
    std::string_view fault;
    Path path;
    Seen seen;
    std::array<int, 4> codes{};        ///< any of them may be the first; docs/codes.md
    std::int64_t known_within_ns = 0;  ///< to the state `fault`; 0: tick path and one more tick
    bool controlled = true;            ///< the axes stop by the controller's own ramp
    bool axis_lies = false;
};

constexpr std::array kRules{
    Rule{"estop", Path::line, Seen::powered, {1}},
    Rule{"estop_blip", Path::line, Seen::powered, {1}},
    Rule{"interlock", Path::line, Seen::lit, {2}},
    Rule{"interlock_blip", Path::line, Seen::lit, {2}},
    Rule{"alarm", Path::guard, Seen::lit, {3}},
    Rule{"alarm_blip", Path::guard, Seen::lit, {3}},
    Rule{"not_ready", Path::guard, Seen::lit, {3}},
    Rule{"back_reflection", Path::guard, Seen::lit, {20}},
    Rule{"temperature", Path::guard, Seen::lit, {21}},
    Rule{"main_supply", Path::guard, Seen::lit, {22}},
    Rule{"housekeeping", Path::guard, Seen::lit, {23}},
    Rule{"system", Path::guard, Seen::lit, {24}},
    Rule{"strange_code", Path::guard, Seen::lit, {25}},
    Rule{"starting", Path::guard, Seen::lit, {3}},
    Rule{"galvo_fail", Path::guard, Seen::lit, {4}},
    Rule{"galvo_blip", Path::guard, Seen::lit, {4}},
    Rule{"galvo_float_low", Path::guard, Seen::lit, {4}},
    Rule{"galvo_float_high", Path::guard, Seen::lit, {4}},
    Rule{"galvo_absent", Path::slow, Seen::own, {17}, 1'200'000'000},  // once it is to be armed
    Rule{"shutter_unplugged", Path::guard, Seen::lit, {18}},
    Rule{"shutter_blip", Path::guard, Seen::own, {18}},
    Rule{"shutter_dropped", Path::slow, Seen::lit, {18}, 70'000'000},
    Rule{"key_off", Path::guard, Seen::lit, {19}},
    Rule{"key_setup", Path::guard, Seen::lit, {19}},
    Rule{"key_blip", Path::guard, Seen::own, {19}},
    // Told at once by its EMCY.
    Rule{"drive_fault_x", Path::tick, Seen::powered, {5}, 0, false},
    Rule{"drive_fault_c", Path::tick, Seen::powered, {5}, 0, false},
    // Two drive cycles without an answer, and the cycle that it came in.
    Rule{"drive_silent_y", Path::slow, Seen::always, {6}, 9'000'000, false},
    Rule{"bus_off", Path::slow, Seen::always, {6}, 9'000'000, false},
    Rule{"freeze_x", Path::slow, Seen::moving, {8, 7}, 60'000'000, false, true},
    Rule{"freeze_z", Path::slow, Seen::moving, {8, 7}, 60'000'000, false, true},
    Rule{"freeze_c", Path::slow, Seen::moving, {8, 7}, 60'000'000, false, true},
    Rule{"stall_x", Path::slow, Seen::moving, {7, 8, 5}, 60'000'000, false, true},
    Rule{"stall_y", Path::slow, Seen::moving, {7, 8, 5}, 60'000'000, false, true},
    Rule{"stall_c", Path::slow, Seen::moving, {7, 8, 5}, 120'000'000, false, true},
    // The report of the drive cycle under way, the next one, and four ticks of suspicion in the dark.
    Rule{"encoder_jump_x", Path::slow, Seen::own, {7, 8}, 9'000'000, false, true},
    Rule{"set_point_jump_x", Path::slow, Seen::own, {7, 8, 5}, 20'000'000, false, true},
    Rule{"rounding", Path::tick, Seen::always, {16}, 0, false},
    Rule{"no_plan", Path::slow, Seen::own, {11}, 200'000'000, false},
    Rule{"reset", Path::tick, Seen::own, {}},
    Rule{"missed_tick", Path::slow, Seen::own, {}},
    Rule{"host_silent", Path::slow, Seen::own, {}},
    Rule{"link_cut", Path::slow, Seen::own, {}},
    Rule{"link_lost", Path::slow, Seen::own, {10}, 10'110'000'000},
    Rule{"abort", Path::slow, Seen::own, {}},
    Rule{"hold", Path::slow, Seen::own, {}},
    Rule{"stream_gap", Path::slow, Seen::own, {}},
};

const Rule* rule_of(std::string_view fault) {
    const auto* const found = std::ranges::find(kRules, fault, &Rule::fault);
    return found == kRules.end() ? nullptr : found;
}

std::size_t axis_of(std::string_view fault) {
    constexpr std::string_view kLetters = "xyzc";
    const std::size_t found = kLetters.find(fault.back());
    return found == std::string_view::npos ? 4 : found;
}

/// How long the light may stay, from the fault.
std::int64_t light_limit(const Rule& rule) {
    switch (rule.path) {
        case Path::line: return kLineNs;
        case Path::guard: return kGuardNs;
        case Path::tick: return kTickPathNs + kTickNs;
        case Path::slow: return rule.known_within_ns;
        case Path::none: break;
    }
    return std::numeric_limits<std::int64_t>::max() / 4;
}

std::int64_t gate_limit(const Rule& rule) { return std::max(light_limit(rule), kGuardNs); }

class Judge {
public:
    Judge(const Trace& trace, const Combination& combination)
        : trace_(trace), fault_(combination), rule_(rule_of(combination.fault)) {}

    Verdict judge() {
        watch_lines();
        watch_guide();
        watch_path();
        if (!fault_.fault.empty() && rule_ != nullptr) {
            verdict_.path = rule_->path;
            measure();
            if (must_trip(fault_.fault, fault_.state) && provoked()) {
                watch_times();
                watch_latch();
                watch_requests();
                watch_rest();
            } else {
                watch_silence();
            }
        }
        return std::move(verdict_);
    }

private:
    void violate(const std::string& what, std::int64_t t_ns) {
        if (verdict_.violations.size() < 8) {
            verdict_.violations.push_back(what + " at " + std::to_string((t_ns - fault_.fault_ns) / 1000) + " us");
        }
    }

    [[nodiscard]] std::string_view state_at(std::int64_t t_ns) const {
        const auto i = static_cast<std::size_t>(std::max<std::int64_t>(0, t_ns / kTickNs));
        return trace_.states.at(std::min(i, trace_.states.size() - 1)).state;
    }

    /// Light needs its lines, in their order: warning, master oscillator, way, gate.
    void watch_lines() {
        std::int64_t oscillator_ns = -1;
        std::int64_t way_ns = -1;
        std::int64_t guide_ns = -1;
        std::size_t state = 0;
        std::int64_t yellow_ns = -1;
        for (const LineEvent& event : trace_.lines) {
            for (; state < trace_.states.size() && trace_.states[state].t_ns <= event.t_ns; ++state) {
                if (!trace_.states[state].yellow) {
                    yellow_ns = -1;
                } else if (yellow_ns < 0) {
                    yellow_ns = trace_.states[state].t_ns;
                }
            }
            switch (event.line) {
                case Line::master_oscillator:
                    oscillator_ns = event.level ? event.t_ns : -1;
                    if (event.level && (yellow_ns < 0 || event.t_ns - yellow_ns < kWarningNs)) {
                        violate("master oscillator without its warning", event.t_ns);
                    }
                    if (event.level && way_ns < 0) {
                        violate("master oscillator before the shutter has opened", event.t_ns);
                    }
                    if (event.level && guide_ns >= 0) {
                        violate("master oscillator with the guide laser", event.t_ns);
                    }
                    break;
                case Line::beam_way: way_ns = event.level ? event.t_ns : -1; break;
                case Line::guide: guide_ns = event.level ? event.t_ns : -1; break;
                case Line::trigger:
                    if (oscillator_ns < 0 || event.t_ns - oscillator_ns < kOscillatorWaitNs) {
                        violate("trigger before the master oscillator's wait is over", event.t_ns);
                    }
                    if (guide_ns >= 0) {
                        violate("trigger in a preview", event.t_ns);
                    }
                    break;
                case Line::gate:
                case Line::guide_asked:
                case Line::shutter_coil: break;
            }
        }
        watch_oscillator();
    }

    /// The master oscillator and the coil go with the states that want them, two ticks later at most.
    void watch_oscillator() {
        for (const LineEvent& event : trace_.lines) {
            if (event.line == Line::trigger && !marked_before(event.t_ns)) {
                violate("trigger outside the state marking", event.t_ns);
            }
            const bool light_line = event.line == Line::master_oscillator || event.line == Line::shutter_coil;
            if (light_line && event.level && !lit(state_at(event.t_ns)) && !lit(state_at(event.t_ns - 2 * kTickNs))) {
                violate("a line of the laser on in " + std::string(state_at(event.t_ns)), event.t_ns);
            }
        }
        std::array<bool, 2> on{};
        std::size_t next = 0;
        int dark_ticks = 0;
        for (const StateSample& sample : trace_.states) {
            for (; next < trace_.lines.size() && trace_.lines[next].t_ns <= sample.t_ns; ++next) {
                const LineEvent& event = trace_.lines[next];
                if (event.line == Line::master_oscillator || event.line == Line::shutter_coil) {
                    on.at(event.line == Line::shutter_coil ? 1 : 0) = event.level;
                }
            }
            dark_ticks = lit(sample.state) ? 0 : dark_ticks + 1;
            if (dark_ticks > 3 && (on[0] || on[1])) {
                violate(std::string(on[0] ? "master oscillator" : "shutter's coil") + " stays on in " +
                            std::string(sample.state),
                        sample.t_ns);
                return;
            }
        }
    }

    [[nodiscard]] bool marked_before(std::int64_t t_ns) const {
        for (std::int64_t back = 0; back <= 2; ++back) {
            if (state_at(t_ns - back * kTickNs) == "marking") {
                return true;
            }
        }
        return false;
    }

    void watch_guide() {
        int others = 0;
        std::size_t next = 0;
        bool on = false;
        bool asked = false;
        for (const StateSample& sample : trace_.states) {
            for (; next < trace_.lines.size() && trace_.lines[next].t_ns <= sample.t_ns; ++next) {
                on = trace_.lines[next].line == Line::guide ? trace_.lines[next].level : on;
                asked = asked || trace_.lines[next].line == Line::guide_asked;
            }
            asked = asked && (sample.state == "idle" || sample.state == "jogging");
            others = sample.state == "previewing" || asked ? 0 : others + 1;
            if (on && others > 3) {
                violate("guide laser on in " + std::string(sample.state), sample.t_ns);
                return;
            }
        }
    }

    /// Nothing is burnt but where the undisturbed job burns.
    void watch_path() {
        if (trace_.path == nullptr) {
            return;
        }
        const double lies = fault_.fault == "set_point_jump_x" ? kOffPathShovedMm : kOffPathAxisMm;
        const double most = rule_ != nullptr && rule_->axis_lies ? lies : kOffPathMm;
        for (auto burn = trace_.burns.rbegin(); burn != trace_.burns.rend(); ++burn) {
            if (burn->t_ns < fault_.fault_ns) {
                break;
            }
            const double off = off_path(*burn);
            if (off > most) {
                violate("light " + std::to_string(off) + " mm off the path", burn->t_ns);
                return;
            }
        }
    }

    [[nodiscard]] double off_path(const Burn& burn) const {
        double nearest = 1e9;
        for (const Burn& right : *trace_.path) {
            double sum = 0.0;
            for (std::size_t i = 0; i < 3; ++i) {
                const double d = right.place.at(i) - burn.place.at(i);
                sum += d * d;
            }
            nearest = std::min(nearest, sum);
        }
        return std::sqrt(nearest);
    }

    void measure() {
        for (const Burn& burn : trace_.burns) {
            if (burn.t_ns >= fault_.fault_ns) {
                verdict_.light_us = static_cast<double>(burn.t_ns - fault_.fault_ns) * 1e-3;
            }
        }
        bool open = false;
        for (const LineEvent& event : trace_.lines) {
            const bool after = event.t_ns >= fault_.fault_ns;
            if (event.line == Line::trigger && after) {
                verdict_.trigger_us = static_cast<double>(event.t_ns - fault_.fault_ns) * 1e-3;
            } else if (event.line == Line::gate) {
                if (after && open && !event.level && !verdict_.gate_us) {
                    verdict_.gate_us = static_cast<double>(event.t_ns - fault_.fault_ns) * 1e-3;
                }
                open = event.level;
            }
        }
        if (open && !verdict_.gate_us) {
            verdict_.gate_us = 1e12;
        }
        for (const StateSample& sample : trace_.states) {
            if (sample.t_ns >= fault_.fault_ns && sample.state == "fault" && rule_->path != Path::slow) {
                // What the tick alone would have done, had nothing been faster.
                verdict_.tick_us = static_cast<double>(sample.t_ns + kCancelNs - fault_.fault_ns) * 1e-3;
                break;
            }
        }
    }

    /// An axis that lies is found out only when it has to move.
    [[nodiscard]] bool provoked() const {
        if (rule_->seen != Seen::moving) {
            return true;
        }
        const std::size_t axis = axis_of(fault_.fault);
        double low = 1e9;
        double high = -1e9;
        for (const AxisSample& sample : trace_.axes) {
            if (sample.t_ns >= fault_.fault_ns && sample.t_ns < fault_.fault_ns + rule_->known_within_ns) {
                low = std::min(low, sample.command.at(axis));
                high = std::max(high, sample.command.at(axis));
            }
        }
        return high - low > (axis == 3 ? 0.2 : 0.6);
    }

    void watch_times() {
        const std::int64_t light = light_limit(*rule_);
        const std::int64_t gate = gate_limit(*rule_);
        if (verdict_.light_us.value_or(0.0) * 1e3 > static_cast<double>(light)) {
            violate("light goes on", fault_.fault_ns + std::llround(*verdict_.light_us * 1e3));
        }
        if (fault_.state != "fault" &&
            verdict_.tick_us.value_or(0.0) * 1e3 > static_cast<double>(kTickPathNs + kTickNs)) {
            violate("the tick is late", fault_.fault_ns + std::llround(*verdict_.tick_us * 1e3));
        }
        if (verdict_.trigger_us.value_or(0.0) * 1e3 > static_cast<double>(gate)) {
            violate("edges pass the gate", fault_.fault_ns + std::llround(*verdict_.trigger_us * 1e3));
        }
        if (verdict_.gate_us.value_or(0.0) * 1e3 > static_cast<double>(gate)) {
            violate("the gate stays open", fault_.fault_ns + std::llround(*verdict_.gate_us * 1e3));
        }
    }

    [[nodiscard]] std::int64_t known_limit() const {
        return rule_->known_within_ns > 0 ? rule_->known_within_ns + 5 * kTickNs : 3 * kTickNs;
    }

    void watch_latch() {
        const bool was = fault_.state == "fault";
        bool latched = was;
        int first = 0;
        for (const StateSample& sample : trace_.states) {
            if (sample.t_ns < fault_.fault_ns) {
                continue;
            }
            const bool reset = !trace_.requests.empty() && granted_reset(sample.t_ns);
            if (sample.state == "fault") {
                if (!latched && std::ranges::find(rule_->codes, sample.first_fault) == rule_->codes.end()) {
                    violate("fault " + std::to_string(sample.first_fault) + " in place of " +
                                std::to_string(rule_->codes[0]),
                            sample.t_ns);
                }
                if (first != 0 && sample.first_fault != first && !reset) {
                    violate("the first fault is forgotten for " + std::to_string(sample.first_fault), sample.t_ns);
                    return;
                }
                first = sample.first_fault;
                latched = true;
            } else if (latched && !reset) {
                violate("left the fault for " + std::string(sample.state), sample.t_ns);
                return;
            } else if (!latched && sample.t_ns > fault_.fault_ns + known_limit()) {
                violate("not latched, in " + std::string(sample.state), sample.t_ns);
                return;
            } else if (latched && reset && sample.state != "disabled") {
                violate("a reset leads to " + std::string(sample.state), sample.t_ns);
                return;
            }
        }
        if (!latched) {
            violate("not latched at all", fault_.fault_ns);
        }
    }

    /// Given by a request that was granted some ticks before or after (the answer takes its time on the line).
    [[nodiscard]] bool granted_reset(std::int64_t t_ns) const {
        return std::ranges::any_of(trace_.requests, [&](const Request& r) {
            return r.verb == "reset" && r.granted && t_ns > r.t_ns - 20 * kTickNs;
        });
    }

    void watch_requests() {
        for (const Request& request : trace_.requests) {
            if (request.verb != "reset" && request.granted) {
                violate("'" + std::string(request.verb) + "' is granted in the fault", request.t_ns);
            } else if (request.verb == "reset" && request.granted && request.cause_present) {
                violate("reset while the cause is there", request.t_ns);
            } else if (request.verb == "reset" && !request.granted && !request.cause_present) {
                violate("reset is refused though the cause is gone", request.t_ns);
            }
        }
    }

    void watch_rest() {
        if (fault_.state == "fault") {
            return;
        }
        bool turning = false;
        std::int64_t moving_ns = fault_.fault_ns;
        for (std::size_t i = 1; i < trace_.axes.size(); ++i) {
            const AxisSample& now = trace_.axes[i];
            if (now.t_ns < fault_.fault_ns) {
                turning = std::abs(now.command[3] - trace_.axes[i - 1].command[3]) > 1e-3;
                continue;
            }
            for (std::size_t axis = 0; axis < 4; ++axis) {
                const double speed = (now.place.at(axis) - trace_.axes[i - 1].place.at(axis)) * 1e3;
                if (std::abs(speed) > kAtRest.at(axis)) {
                    moving_ns = now.t_ns;
                }
            }
        }
        verdict_.rest_ms = static_cast<double>(moving_ns - fault_.fault_ns) * 1e-6;
        const std::int64_t limit = (turning || fault_.phase == "turning" ? kTurnStopNs : kStopNs) + known_limit();
        if (moving_ns - fault_.fault_ns > limit) {
            violate("the axes still move", moving_ns);
        }
        if (rule_->controlled && fault_.state != "homing") {
            watch_ramp();
        }
    }

    /// A ramp of the controller's own keeps to the axes' limits until it has come to rest.
    void watch_ramp() {
        for (std::size_t axis = 0; axis < 4; ++axis) {
            for (std::size_t i = 2; i < trace_.axes.size(); ++i) {
                if (trace_.axes[i].t_ns < fault_.fault_ns || state_at(trace_.axes[i - 2].t_ns) == "homing") {
                    continue;
                }
                const double before = trace_.axes[i - 1].command.at(axis) - trace_.axes[i - 2].command.at(axis);
                const double now = trace_.axes[i].command.at(axis) - trace_.axes[i - 1].command.at(axis);
                if (now == 0.0 && std::abs(before) * 1e3 < kAtRest.at(axis)) {
                    break;
                }
                if (std::abs(now - before) * 1e6 > kAcceleration.at(axis)) {
                    violate("axis " + std::to_string(axis) + " stops too hard", trace_.axes[i].t_ns);
                    return;
                }
            }
        }
    }

    /// Faults that need not trip there: nothing may burn that would not have burnt without them, and what ends in
    /// another way does so in time.
    void watch_silence() {
        const bool silent = fault_.fault == "host_silent" || fault_.fault == "link_cut";
        if (silent) {
            // The heartbeat's time of 100 ms from the last word, the tick that sees it, and 10 µs.
            const double limit_us = 100e3 + 1e3 * 1e-3 * static_cast<double>(kTickPathNs) * 1e-3 + 1e3;
            if (verdict_.light_us.value_or(0.0) > limit_us) {
                violate("light goes on without a host", fault_.fault_ns + std::llround(*verdict_.light_us * 1e3));
            }
            expect_state_after_silence();
        }
        if (fault_.fault == "reset") {
            if (verdict_.light_us.value_or(0.0) * 1e3 > static_cast<double>(kTickPathNs + kTickNs)) {
                violate("light after a reset", fault_.fault_ns);
            }
            const std::string_view last = trace_.states.back().state;
            if (last != "boot" && last != "disabled") {
                violate("a controller that has started anew is in " + std::string(last), trace_.states.back().t_ns);
            }
        }
    }

    void expect_state_after_silence() {
        std::string_view wanted;
        if (fault_.state == "marking" || fault_.state == "running" || fault_.state == "held" ||
            fault_.state == "held_link" || fault_.state == "stopping") {
            wanted = "held_link";
        } else if (fault_.state == "armed" || fault_.state == "arming" || fault_.state == "jogging" ||
                   fault_.state == "homing" || fault_.state == "previewing" || fault_.state == "preview_stopping" ||
                   fault_.state == "idle") {
            wanted = "idle";
        } else {
            return;
        }
        if (trace_.states.back().state != wanted) {
            violate("a silent host leaves the cell in " + std::string(trace_.states.back().state),
                    trace_.states.back().t_ns);
        }
    }

    const Trace& trace_;
    const Combination& fault_;
    const Rule* rule_;
    Verdict verdict_;
};

bool on_path(std::string_view state) { return among(kPathStates, state); }

}  // namespace

std::string cannot_be(std::string_view fault, std::string_view state, std::string_view phase) {
    if (fault == "galvo_absent" && lit(state)) {
        return "a converter that says 'all well' cannot be told from a head that has been proven";
    }
    const bool dark_state = state == "running" || state == "previewing" || state == "stopping";
    if (phase == "none") {
        return on_path(state) ? "the state has phases of its own" : "";
    }
    if (!on_path(state)) {
        return "no path is run in this state";
    }
    if ((phase == "jump" || phase == "dwell" || phase == "turning") && !dark_state) {
        return "between paths the state is running";
    }
    if (state == "stopping" && (phase == "cruise" || phase == "dwell")) {
        return "what stops has no constant speed, and what stands does not stop";
    }
    if ((phase == "cruise" || phase == "corner") && state == "running") {
        return "on a line the state is marking";
    }
    if (phase == "ramp" && state == "marking") {
        return "speed is reached before the line begins (run-in, state running)";
    }
    return "";
}

bool must_trip(std::string_view fault, std::string_view state) {
    const Rule* const rule = rule_of(fault);
    if (rule == nullptr || state.empty()) {
        return false;
    }
    if (fault == "reset") {
        return false;  // it starts anew
    }
    if (state == "fault") {
        return true;  // it stays
    }
    switch (rule->seen) {
        case Seen::lit: return lit(state);
        case Seen::powered: return powered(state);
        case Seen::always: return state != "boot" || fault == "rounding";
        case Seen::moving: return powered(state) && state != "enabling" && state != "homing";
        case Seen::own: break;
    }
    if (fault == "galvo_absent") {
        return state == "idle";
    }
    if (fault == "no_plan") {
        return state == "marking";
    }
    if (fault == "key_blip" || fault == "shutter_blip") {
        return state == "marking";  // between ticks they are asked for only while pulses may leave
    }
    if (fault == "encoder_jump_x" || fault == "set_point_jump_x") {
        return powered(state) && state != "enabling" && state != "homing";
    }
    if (fault == "link_lost") {
        return state == "held_link";
    }
    return false;
}

Verdict judge(const Trace& trace, const Combination& combination) { return Judge(trace, combination).judge(); }

}  // namespace sc::faults
