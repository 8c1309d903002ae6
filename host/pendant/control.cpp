// SPDX-License-Identifier: Apache-2.0
#include "host/pendant/control.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include "host/formats/error.hpp"

namespace sc::host::pendant {
namespace {

constexpr double kMetresPerUm = 1e-6;
constexpr double kDegreesPerUm = 1e-3;
constexpr int kOverrideStep = 10;
constexpr int kLeastOverride = 10;
constexpr int kMostOverride = 200;

constexpr std::array kPlaces{FeedKnob::mm_0_001,   FeedKnob::mm_0_01,     FeedKnob::mm_0_1, FeedKnob::mm_1,
                             FeedKnob::percent_60, FeedKnob::percent_100, FeedKnob::lead};
constexpr std::array<const char*, kPlaces.size()> kPrinted{"0.001", "0.01", "0.1", "1", "60 %", "100 %", "Lead"};

std::optional<Axis> axis_of(AxisKnob knob) {
    switch (knob) {
        case AxisKnob::x: return Axis::x;
        case AxisKnob::y: return Axis::y;
        case AxisKnob::z: return Axis::z;
        case AxisKnob::c: return Axis::c;
        case AxisKnob::unknown:
        case AxisKnob::off:
        case AxisKnob::a:
        case AxisKnob::b: break;
    }
    return std::nullopt;
}

}  // namespace

double StepTable::step(FeedKnob knob, bool turn) const {
    const auto* place = std::ranges::find(kPlaces, knob);
    if (place == kPlaces.end()) {
        return 0.0;
    }
    return um.at(static_cast<std::size_t>(place - kPlaces.begin())) * (turn ? kDegreesPerUm : kMetresPerUm);
}

std::string StepTable::text() const {
    std::string out;
    for (std::size_t i = 0; i < um.size(); ++i) {
        if (um.at(i) > 0.0) {
            out += fmt::format("{}{}: {:g} um", out.empty() ? "" : ", ", kPrinted.at(i), um.at(i));
        }
    }
    return out;
}

StepTable step_table(std::span<const double> um) {
    StepTable table;
    if (um.size() != 5 && um.size() != table.um.size()) {
        throw InputError({.problem = "the table of steps has another number of them",
                          .value = std::to_string(um.size()),
                          .action = "give five, for 0.001, 0.01, 0.1, 1 and 60 %, or seven, for 100 % and Lead too"});
    }
    table.um = {};
    for (std::size_t i = 0; i < um.size(); ++i) {
        if (!(um[i] == 0.0 || (um[i] >= 0.1 && um[i] <= kLargestStepUm))) {
            throw InputError({.problem = "a step is out of range, micrometres",
                              .value = fmt::format("{:g}", um[i]),
                              .action = fmt::format("use 0 for none, or 0.1..{:g}", kLargestStepUm)});
        }
        table.um.at(i) = um[i];
    }
    return table;
}

std::optional<Axis> PendantControl::axis() const { return last_ ? axis_of(last_->axis) : std::nullopt; }

double PendantControl::step() const {
    const auto now = axis();
    return now ? options_.steps.step(last_->feed, *now == Axis::c) : 0.0;
}

void PendantControl::stop(std::vector<Wish>& out, bool disarm, const char* why) {
    must_turn_ = must_turn_ || disarm;
    if (!stopping_) {
        stopping_ = true;
        ++counters_.stops;
        out.push_back({.kind = WishKind::stop, .disarmed = disarm, .why = why});
    }
}

void PendantControl::plugged() {
    connected_ = true;
    last_.reset();
}

std::vector<Wish> PendantControl::unplugged(const CellView& /*cell*/) {
    std::vector<Wish> out;
    connected_ = false;
    last_.reset();
    ++counters_.unplugs;
    // Whether or not a move is known to be under way: one may have been asked for a moment ago.
    stopping_ = false;
    stop(out, true, "the pendant is unplugged");
    return out;
}

std::vector<Wish> PendantControl::pass(HostTime now, const CellView& cell) {
    std::vector<Wish> out;
    if (!cell.moving) {
        stopping_ = false;
    } else if (now - turned_ > options_.dead_man) {
        stop(out, true, "the wheel has been still for too long");
    }
    return out;
}

std::vector<Wish> PendantControl::take(std::span<const std::uint8_t> bytes, HostTime now, Nanoseconds age,
                                       const CellView& cell) {
    std::vector<Wish> out;
    ++counters_.reports;
    const auto report = parse_report(bytes);
    if (!report) {
        ++counters_.malformed;
        return out;
    }
    if (!cell.moving) {
        stopping_ = false;
    }
    const bool known = last_.has_value();
    keys(*report, cell, out);
    knobs(*report, cell, out);
    last_ = *report;
    if (report->detents != 0) {
        wheel(*report, now, age, known, cell, out);
    }
    return out;
}

void PendantControl::knobs(const Report& report, const CellView& cell, std::vector<Wish>& out) {
    if (!last_) {
        out.push_back({.kind = WishKind::shown});
        return;
    }
    const bool axis_turned = report.axis != last_->axis;
    if (!axis_turned && report.feed == last_->feed) {
        return;
    }
    if (axis_turned && !cell.moving) {
        must_turn_ = false;
    }
    if (cell.moving) {
        stop(out, false, axis_turned ? "the axis knob was turned" : "the feed knob was turned");
    }
    out.push_back({.kind = WishKind::shown});
}

void PendantControl::keys(const Report& report, const CellView& cell, std::vector<Wish>& out) {
    if (report.holds(Key::stop) && !(last_ && last_->holds(Key::stop))) {
        stopping_ = false;
        stop(out, true, "the key Stop");
    }
    if (options_.hold_fn && cell.moving && !report.holds(Key::fn)) {
        stop(out, false, "Fn was let go");
    }
    // What is held while it is plugged in was not pressed for this cell.
    const auto pressed = [&](Key key) { return last_ && report.holds(key) && !last_->holds(key); };
    const int feed = (pressed(Key::feed_plus) ? kOverrideStep : 0) - (pressed(Key::feed_minus) ? kOverrideStep : 0);
    if (feed != 0) {
        const int wanted = report.holds(Key::fn) ? 100 : cell.override_percent + feed;
        out.push_back({.kind = WishKind::override,
                       .percent = static_cast<std::uint8_t>(std::clamp(wanted, kLeastOverride, kMostOverride))});
    }
    constexpr std::array<std::pair<Key, WishKind>, 5> kPlain{{{Key::start_pause, WishKind::start_pause},
                                                              {Key::reset, WishKind::reset},
                                                              {Key::probe_z, WishKind::take},
                                                              {Key::safe_z, WishKind::skip},
                                                              {Key::workpiece_home, WishKind::undo}}};
    for (const auto& [key, kind] : kPlain) {
        if (pressed(key)) {
            out.push_back({.kind = kind});
        }
    }
}

void PendantControl::wheel(const Report& report, HostTime now, Nanoseconds age, bool known, const CellView& cell,
                           std::vector<Wish>& out) {
    const auto count = static_cast<std::uint64_t>(std::abs(report.detents));
    const double size = step();
    if (!connected_ || !known || must_turn_ || size <= 0.0 || (options_.hold_fn && !report.holds(Key::fn))) {
        counters_.unarmed += count;
        return;
    }
    if (!report.proven) {
        counters_.unproven += count;
        return;
    }
    if (age > kOldest) {
        counters_.late += count;
        return;
    }
    turned_ = now;
    if (cell.moving || stopping_) {
        counters_.busy += count;
        return;
    }
    const bool turn = *axis() == Axis::c;
    const auto most = static_cast<std::uint64_t>(std::floor((turn ? kMostTurn : kMost) / size + 1e-9));
    const std::uint64_t taken = std::min({count, most, static_cast<std::uint64_t>(kMostDetents)});
    counters_.moved += taken;
    counters_.beyond += count - taken;
    out.push_back({.kind = WishKind::jog,
                   .axis = *axis(),
                   .distance = (report.detents > 0 ? 1.0 : -1.0) * static_cast<double>(taken) * size});
}

}  // namespace sc::host::pendant
