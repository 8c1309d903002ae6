// SPDX-License-Identifier: Apache-2.0
#include "host/path/split_path.hpp"

#include <algorithm>
#include <cmath>

#include "host/path/check.hpp"

namespace sc::host {
namespace {

constexpr double kLongestArc = 4.0;      ///< rad, of one item
constexpr double kLongestItem = 1.5;     ///< of a split path: in knots' spacings
constexpr double kSampleSpacing = 0.25;  ///< … at which the reach is looked at
constexpr double kNoJump = 20e-6;        ///< metres: a jump shorter than this is none
constexpr double kKnotSpare = 1e-3;      ///< metres
constexpr double kSlowest = 0.25;        ///< of the speed asked for
constexpr int kSpeedSteps = 5;           ///< of halving what is between possible and not

std::int32_t wire(double metres) { return static_cast<std::int32_t>(std::llround(metres * kWireUnitsPerMetre)); }
PathPoint wire_point(const Vec3& place) { return {wire(place.x), wire(place.y), wire(place.z)}; }

/// Items of the path without its begin and end, and what the stage must be near.
class Walk {
public:
    Walk(const PathBegin& begin, const MachineConfig& machine, const StageRules& rules)
        : machine_(machine), rules_(rules), split_(begin.actuator == Actuator::split) {
        settings_.actuator = begin.actuator;
        settings_.speed = Speed::from_si(rules.speed);
    }

    void begin_at(const Vec3& place, const Vec3& direction) {
        length_ = run_up(direction);
        sample(place - length_ * direction, 0.0, false);
        sample(place, length_, true);
        items_.push_back({wire_point(place), length_});
        at_ = place;
    }
    void light(bool on) { items_.push_back({PathLight{on}, length_}); }
    void jump(const Vec3& to) {
        const double whole = norm(to - at_);
        go({at_, to, std::nullopt, 0}, whole, false);
        dark_ += whole;
    }
    void mark(const Piece& piece) { go(piece, piece.length(), true); }
    void end_at(const Vec3& direction) {
        const double run_out = run_up(direction);
        sample(at_ + run_out * direction, length_ + run_out, false);
        length_ += run_out;
    }
    /// Length of the dark stretch before and behind a line.
    [[nodiscard]] double turn(const Vec3& direction) const { return run_in_length(direction, settings_, machine_); }

    struct Numbered {
        Item item;
        double distance = 0.0;  ///< that the path has come behind it
    };
    [[nodiscard]] const std::vector<Numbered>& items() const { return items_; }
    [[nodiscard]] const std::vector<StagePlace>& places() const { return places_; }
    [[nodiscard]] double length() const { return length_; }
    [[nodiscard]] double dark() const { return dark_; }
    [[nodiscard]] const Vec3& at() const { return at_; }

private:
    [[nodiscard]] double run_up(const Vec3& direction) const {
        return speed_up_distance(rules_.speed, limits_along(direction, settings_.actuator, machine_));
    }
    void sample(const Vec3& place, double distance, bool marked) { places_.push_back({distance, place, marked}); }
    void go(const Piece& piece, double whole, bool marked) {
        int parts = split_ ? static_cast<int>(std::ceil(whole / (kLongestItem * rules_.spacing))) : 1;
        if (piece.circle) {
            // The middle as via keeps the circle best through rounding; almost a whole circle is two arcs for its sake.
            parts = std::max(parts, piece.circle->angle > kLongestArc ? 2 : 1);
        }
        parts = std::max(parts, 1);
        for (int part = 1; part <= parts; ++part) {
            const Vec3 to = part == parts ? piece.to : piece.at(static_cast<double>(part) / parts);
            length_ += whole / parts;
            if (piece.circle) {
                items_.push_back({PathArc{wire_point(piece.at((part - 0.5) / parts)), wire_point(to)}, length_});
            } else {
                items_.push_back({wire_point(to), length_});
            }
        }
        const auto samples = static_cast<int>(std::ceil(whole / (kSampleSpacing * rules_.spacing)));
        for (int i = 1; i <= std::max(samples, 1); ++i) {
            const double share = static_cast<double>(i) / std::max(samples, 1);
            sample(piece.at(share), length_ - whole * (1.0 - share), marked);
        }
        at_ = piece.to;
    }

    const MachineConfig& machine_;
    const StageRules& rules_;
    bool split_;
    MarkSettings settings_;
    std::vector<Numbered> items_;
    std::vector<StagePlace> places_;
    double length_ = 0.0;
    double dark_ = 0.0;
    Vec3 at_;
};

void walk_all(Walk& walk, std::span<const Stroke3> strokes) {
    for (std::size_t i = 0; i < strokes.size(); ++i) {
        const Stroke3& stroke = strokes[i];
        const Vec3 first = stroke.front().direction(0.0);
        const Vec3 last = stroke.back().direction(1.0);
        const Vec3 start = stroke.front().from;
        if (i == 0) {
            walk.begin_at(start, first);
        } else {
            const Vec3 before = start - walk.turn(first) * first;
            if (norm(before - walk.at()) > kNoJump) {
                walk.jump(before);
            }
            walk.jump(start);
            walk.light(true);
        }
        for (const Piece& piece : stroke) {
            walk.mark(piece);
        }
        if (i + 1 < strokes.size()) {
            walk.light(false);
            walk.jump(walk.at() + walk.turn(last) * last);
        } else {
            walk.end_at(last);
        }
    }
}

}  // namespace

StrokePath stroke_path(const PathBegin& begin, std::span<const Stroke3> strokes, const MachineConfig& machine,
                       double depth) {
    const StageRules rules = stage_rules(begin.speed_um_s * 1e-6, machine, depth);
    Walk walk(begin, machine, rules);
    walk_all(walk, strokes);
    StrokePath path{.items = {begin}, .length = walk.length(), .dark_length = walk.dark(), .stage = {}};
    // The controller counts a run-in of the longest that there can be.
    const auto knots_for = [&](double distance) {
        return static_cast<std::size_t>(std::floor((distance + kKnotSpare) / rules.spacing + 0.5)) + 4;
    };
    std::size_t given = 0;
    const auto give_knots = [&](std::size_t count) {
        for (; given < std::min(count, path.stage.control.size()); ++given) {
            const PathPoint place = wire_point(path.stage.control[given]);
            path.items.emplace_back(StageKnot{place.x, place.y, place.z});
        }
    };
    const bool split = begin.actuator == Actuator::split;
    if (split) {
        path.stage = fit_stage(walk.places(), knots_for(walk.length()), rules);
        path.items.emplace_back(StageCurve{static_cast<std::uint32_t>(std::llround(rules.spacing * 1e6))});
    }
    for (const Walk::Numbered& numbered : walk.items()) {
        give_knots(knots_for(numbered.distance));
        path.items.push_back(numbered.item);
    }
    give_knots(path.stage.control.size());
    path.items.emplace_back(PathEnd{});
    return path;
}

StrokePath split_path(const PathBegin& begin, std::span<const Stroke3> strokes, const MachineConfig& machine,
                      double depth) {
    const auto possible = [](const StrokePath& path) { return path.stage.worst <= 1.0 + kStageSlack; };
    const auto at_share = [&](double share) {
        PathBegin slower = begin;
        slower.speed_um_s = static_cast<std::uint32_t>(begin.speed_um_s * share);
        return stroke_path(slower, strokes, machine, depth);
    };
    StrokePath best = stroke_path(begin, strokes, machine, depth);
    if (possible(best)) {
        return best;
    }
    StrokePath slow = at_share(kSlowest);
    if (!possible(slow)) {
        return best;
    }
    best = std::move(slow);
    double low = kSlowest;
    double high = 1.0;
    for (int i = 0; i < kSpeedSteps; ++i) {
        const double middle = 0.5 * (low + high);
        StrokePath tried = at_share(middle);
        if (possible(tried)) {
            low = middle;
            best = std::move(tried);
        } else {
            high = middle;
        }
    }
    return best;
}

}  // namespace sc::host
