// SPDX-License-Identifier: Apache-2.0
#include "host/verification/pulse_checker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace sc::host {
namespace {

/// Two pulses further apart than this belong to different paths: a jump with its run-out and run-in takes longer, and
/// the slowest mark has its next pulse sooner.
constexpr std::int64_t kDarkNs = 2'500'000;
/// Or so many pitches: dark stretches of a path may be passed sooner.
constexpr double kDarkPitches = 8.0;
/// A polyline that turns by less at a point is taken for chords of a curve. rad
constexpr double kSharpAngle = 0.8;
/// Where a path stands by itself is known from so many pulses of it.
constexpr std::size_t kStandPulses = 50;
/// From a trigger to its light.
constexpr std::int64_t kGateSlackNs = 1'000;
constexpr double kPerMillimetre = 1e-3;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

Vec3 place_of(const PathPoint& p) {
    return {p.x / kWireUnitsPerMetre, p.y / kWireUnitsPerMetre, p.z / kWireUnitsPerMetre};
}
Vec3 place_of(const trace::PulseRecord& pulse) {
    const auto metres = [](std::int64_t pm) { return static_cast<double>(pm) * 1e-12; };
    return {metres(pulse.place_pm[0]), metres(pulse.place_pm[1]), metres(pulse.place_pm[2])};
}
/// Across the beam.
double apart(const Vec3& a, const Vec3& b) { return std::hypot(a.x - b.x, a.z - b.z); }

/// Light between one dark and the next.
std::vector<std::span<const trace::PulseRecord>> split(std::span<const trace::PulseRecord> pulses, double dark) {
    std::vector<std::span<const trace::PulseRecord>> parts;
    std::size_t begin = 0;
    for (std::size_t i = 1; i <= pulses.size(); ++i) {
        if (i == pulses.size() || pulses[i].t_ns - pulses[i - 1].t_ns > kDarkNs ||
            apart(place_of(pulses[i]), place_of(pulses[i - 1])) > dark) {
            parts.push_back(pulses.subspan(begin, i - begin));
            begin = i;
        }
    }
    return parts;
}

void keep(PulseFigures& out, const PulseViolation& violation) {
    ++out.violations;
    if (out.first.size() < kKeptPulseViolations) {
        out.first.push_back(violation);
    }
}

/// Those that met the surface; the others are violations.
std::vector<trace::PulseRecord> met(const std::vector<trace::PulseRecord>& pulses, PulseFigures& out) {
    std::vector<trace::PulseRecord> kept;
    kept.reserve(pulses.size());
    for (std::size_t k = 0; k < pulses.size(); ++k) {
        if (pulses[k].hit != 0) {
            kept.push_back(pulses[k]);
        } else {
            keep(out, {.breach = PulseBreach::missed, .pulse = k, .t_ns = pulses[k].t_ns, .value = 1.0});
        }
    }
    return kept;
}

/// Judges one stretch after the other.
class Judge {
public:
    Judge(const PulseCheck& check, PulseFigures& out) : check_(check), out_(out) {}

    void stretch(const DrawnJobPath& path, std::span<const trace::PulseRecord> pulses, const Vec3& stand);
    void end() {
        out_.placement_rms = std::sqrt(place_square_ / static_cast<double>(std::max<std::size_t>(out_.pulses, 1)));
        out_.pitch_rms = std::sqrt(pitch_square_ / static_cast<double>(std::max<std::size_t>(pitches_, 1)));
    }

private:
    /// A share off what is asked for.
    void limit(PulseBreach breach, double error, double most, std::size_t pulse) {
        if (check_.limits && !(std::abs(error) <= most)) {
            note(breach, pulse, 1.0 + error, error > 0.0 ? 1.0 + most : 1.0 - most);
        }
    }
    void note(PulseBreach breach, std::size_t pulse, double value, double most) {
        const std::int64_t t_ns = pulse < pulses_.size() ? pulses_[pulse].t_ns : 0;
        keep(out_, {breach, path_->begin.path, path_->begin.pass, pulse, t_ns, value, most});
    }
    void count();
    void energy_of_lengths(const std::vector<double>& along, const std::vector<double>& straight);

    const PulseCheck& check_;
    PulseFigures& out_;
    const DrawnJobPath* path_ = nullptr;
    std::span<const trace::PulseRecord> pulses_;
    double place_square_ = 0.0;
    double pitch_square_ = 0.0;
    std::size_t pitches_ = 0;
};

void Judge::count() {
    const std::size_t expected = path_->pulses();
    const std::size_t lost = pulses_.size() > expected ? pulses_.size() - expected : expected - pulses_.size();
    out_.lost += lost;
    if (check_.limits && static_cast<double>(lost) > std::ceil(path_->slack / path_->pitch())) {
        note(PulseBreach::count, pulses_.size(), static_cast<double>(pulses_.size()), static_cast<double>(expected));
    }
}

void Judge::energy_of_lengths(const std::vector<double>& along, const std::vector<double>& straight) {
    const double pitch = path_->pitch();
    const double energy = path_->begin.energy_nj;
    const auto window = static_cast<std::size_t>(std::lround(kPerMillimetre / pitch));
    double light = 0.0;
    for (std::size_t k = 0; k < pulses_.size(); ++k) {
        light += pulses_[k].energy_nj;
        if (k < window) {
            continue;
        }
        light -= pulses_[k - window].energy_nj;
        const auto error_of = [&](const std::vector<double>& way) {
            return light / (way[k] - way[k - window]) * pitch / energy - 1.0;
        };
        double error = error_of(along);
        error = check_.limits && std::abs(error_of(straight)) < std::abs(error) ? error_of(straight) : error;
        out_.energy_per_length_peak = std::max(out_.energy_per_length_peak, std::abs(error));
        limit(PulseBreach::energy_per_length, error, check_.limits ? check_.limits->energy : 0.0, k);
    }
}

void Judge::stretch(const DrawnJobPath& path, std::span<const trace::PulseRecord> pulses, const Vec3& stand) {
    path_ = &path;
    pulses_ = pulses;
    const double pitch = path.pitch();
    const double energy = path.begin.energy_nj;
    const PulseLimits limits = check_.limits.value_or(PulseLimits{});
    out_.pulses += pulses.size();
    count();
    std::vector<double> along;
    std::vector<double> straight(pulses.size(), 0.0);
    along.reserve(pulses.size());
    for (std::size_t k = 0; k < pulses.size(); ++k) {
        const Vec3 place = place_of(pulses[k]) - stand;
        const double off = apart(place, path.place(k));
        place_square_ += off * off;
        out_.placement_peak = std::max(out_.placement_peak, off);
        // From the pulse before, so that a path that crosses itself is not mistaken.
        const double from = along.empty() ? path.from - pitch : along.back();
        along.push_back(path.path->nearest(place, from - pitch, from + 3.0 * pitch));
        const double energy_error = pulses[k].energy_nj / energy - 1.0;
        out_.energy_peak = std::max(out_.energy_peak, std::abs(energy_error));
        limit(PulseBreach::energy, energy_error, limits.pulse_energy, k);
        if (k > 0) {
            double error = (along[k] - along[k - 1]) / pitch - 1.0;
            straight[k] = straight[k - 1] + apart(place_of(pulses[k]), place_of(pulses[k - 1]));
            const double chord = (straight[k] - straight[k - 1]) / pitch - 1.0;
            error = check_.limits && std::abs(chord) < std::abs(error) ? chord : error;
            pitch_square_ += error * error;
            ++pitches_;
            out_.pitch_peak = std::max(out_.pitch_peak, std::abs(error));
            limit(PulseBreach::pitch, error, limits.pitch, k);
        }
    }
    energy_of_lengths(along, straight);
    if (!pulses.empty()) {
        const double counted = path.from + static_cast<double>(pulses.size() - 1) * pitch;
        const double along_path =
            path.path->nearest(place_of(pulses.back()) - stand, counted - 50.0 * pitch, counted + 50.0 * pitch);
        out_.drift = std::max({out_.drift, std::round(std::abs(along_path - counted) / pitch),
                               std::abs(static_cast<double>(pulses.size()) - static_cast<double>(path.pulses()))});
    }
}

/// Sum of pulse less the place of its number.
Vec3 sum_off(const DrawnJobPath& path, std::span<const trace::PulseRecord> pulses) {
    Vec3 sum{};
    for (std::size_t k = 0; k < pulses.size(); ++k) {
        sum = sum + (place_of(pulses[k]) - path.place(k));
    }
    return sum;
}

/// Cuts paths into what is marked of them.
class Drawer {
public:
    void add(const Item& item) {
        if (const auto* begin = std::get_if<PathBegin>(&item)) {
            path_ = std::make_shared<DrawnPath>();
            begin_ = *begin;
            points_ = 0;
            open(0.0);
        } else if (const auto* point = std::get_if<PathPoint>(&item)) {
            path().meet(points_++ == 0, *point);
        } else if (const auto* arc = std::get_if<PathArc>(&item)) {
            path().arc(arc->via, arc->to);
        } else if (const auto* light = std::get_if<PathLight>(&item)) {
            light->on ? open(path().length()) : shut(path().length());
        } else if (std::holds_alternative<PathEnd>(item)) {
            if (!(path().length() > 0.0)) {
                throw std::domain_error("path " + std::to_string(begin_.path) + " has no length");
            }
            shut(path().length());
            path_.reset();
        }
    }
    std::vector<DrawnJobPath> take() { return std::move(stretches_); }

private:
    DrawnPath& path() {
        if (!path_) {
            throw std::domain_error("a point, an arc or a light outside a path");
        }
        return *path_;
    }
    void open(double at) { stretches_.push_back({begin_, path_, at, at, 0.0}); }
    void shut(double at) {
        DrawnJobPath& stretch = stretches_.back();
        stretch.to = at;
        stretch.slack = path_->slack(stretch.from, at, begin_.tolerance_nm * 1e-9);
    }

    std::vector<DrawnJobPath> stretches_;
    std::shared_ptr<DrawnPath> path_;
    PathBegin begin_{};
    int points_ = 0;
};

}  // namespace

void DrawnPath::meet(bool first, const PathPoint& point) {
    if (first) {
        last_ = place_of(point);
    } else {
        line_to(point);
    }
}

void DrawnPath::line_to(const PathPoint& point) {
    const Vec3 to = place_of(point);
    const double length = std::hypot(to.x - last_.x, to.y - last_.y, to.z - last_.z);
    if (length > 0.0) {
        spans_.push_back(
            {.begin = this->length(), .length = length, .from = last_, .way = (1.0 / length) * (to - last_)});
    }
    last_ = to;
}

void DrawnPath::arc(const PathPoint& via, const PathPoint& to) {
    const Vec3 a = last_;
    const Vec3 b = place_of(via);
    const Vec3 c = place_of(to);
    // Centre of the circle through three places, relative to the first.
    const double bx = b.x - a.x;
    const double bz = b.z - a.z;
    const double cx = c.x - a.x;
    const double cz = c.z - a.z;
    const double twice = 2.0 * (bx * cz - bz * cx);
    if (std::abs(twice) < 1e-18) {
        throw std::domain_error("an arc whose three places lie on a line");
    }
    const double bb = bx * bx + bz * bz;
    const double cc = cx * cx + cz * cz;
    const Vec3 centre{a.x + (cz * bb - bz * cc) / twice, a.y, a.z + (bx * cc - cx * bb) / twice};
    const auto angle = [&](const Vec3& p) { return std::atan2(p.z - centre.z, p.x - centre.x); };
    const auto ahead = [](double turn) { return turn < 0.0 ? turn + kTwoPi : turn; };
    const double begin = angle(a);
    const double to_via = ahead(angle(b) - begin);
    const double to_end = ahead(angle(c) - begin);
    const double turn = to_via < to_end ? to_end : to_end - kTwoPi;
    const double radius = apart(a, centre);
    spans_.push_back({.begin = length(),
                      .length = radius * std::abs(turn),
                      .from = a,
                      .centre = centre,
                      .radius = radius,
                      .angle = begin,
                      .turn = turn});
    last_ = c;
}

double DrawnPath::length() const { return spans_.empty() ? 0.0 : spans_.back().begin + spans_.back().length; }

Vec3 DrawnPath::place_in(const Span& span, double s) {
    if (span.radius == 0.0) {
        return span.from + s * span.way;
    }
    const double angle = span.angle + span.turn * (s / span.length);
    return {span.centre.x + span.radius * std::cos(angle), span.from.y, span.centre.z + span.radius * std::sin(angle)};
}

Vec3 DrawnPath::at(double length) const {
    const auto behind = std::upper_bound(spans_.begin(), spans_.end(), length,
                                         [](double s, const Span& span) { return s < span.begin; });
    const Span& span = behind == spans_.begin() ? spans_.front() : *(behind - 1);
    return place_in(span, length - span.begin);
}

double DrawnPath::nearest_in(const Span& span, const Vec3& place) {
    if (span.radius == 0.0) {
        const double across = span.way.x * span.way.x + span.way.z * span.way.z;
        return across > 0.0 ? ((place.x - span.from.x) * span.way.x + (place.z - span.from.z) * span.way.z) / across
                            : 0.0;
    }
    double turned = std::atan2(place.z - span.centre.z, place.x - span.centre.x) - span.angle;
    turned *= span.turn < 0.0 ? -1.0 : 1.0;
    // The middle of the arc is where there must be no step.
    const double middle = 0.5 * std::abs(span.turn);
    turned -= kTwoPi * std::round((turned - middle) / kTwoPi);
    return turned * span.radius;
}

double DrawnPath::nearest(const Vec3& place, double low, double high) const {
    auto span =
        std::upper_bound(spans_.begin(), spans_.end(), low, [](double s, const Span& one) { return s < one.begin; });
    if (span != spans_.begin()) {
        --span;
    }
    double best = 1e300;
    double found = low;
    for (; span != spans_.end() && span->begin <= high; ++span) {
        // The first and the last go on beyond their ends, along their own lines.
        const double least = span == spans_.begin() ? -1e300 : 0.0;
        const double most = span + 1 == spans_.end() ? 1e300 : span->length;
        const double s = std::clamp(nearest_in(*span, place), least, most);
        const double distance = apart(place, place_in(*span, s));
        if (distance < best) {
            best = distance;
            found = span->begin + s;
        }
    }
    return found;
}

std::string_view name_of(PulseBreach breach) noexcept {
    switch (breach) {
        case PulseBreach::paths: return "paths";
        case PulseBreach::count: return "count";
        case PulseBreach::pitch: return "pitch";
        case PulseBreach::energy: return "energy";
        case PulseBreach::energy_per_length: return "energy_per_length";
        case PulseBreach::missed: return "missed";
        case PulseBreach::gate_shut: return "gate_shut";
    }
    return "";
}

double DrawnPath::slack(double from, double to, double tolerance) const {
    double turned = 0.0;
    double bent = 0.0;
    for (std::size_t i = 0; i < spans_.size(); ++i) {
        const Span& span = spans_[i];
        if (span.begin >= from && span.begin < to) {
            turned += std::abs(span.turn);
        }
        if (i == 0 || span.begin <= from || span.begin >= to) {
            continue;
        }
        const Span& before = spans_[i - 1];
        const double step = 1e-3 * std::min(before.length, span.length);
        const Vec3 in = place_in(before, before.length) - place_in(before, before.length - step);
        const Vec3 out = place_in(span, step) - place_in(span, 0.0);
        const double angle = std::abs(std::atan2(in.x * out.z - in.z * out.x, in.x * out.x + in.z * out.z));
        turned += angle;
        bent += angle < kSharpAngle ? angle * angle / 48.0 * (before.length + span.length) : 0.0;
    }
    return turned * tolerance + bent;
}

std::size_t DrawnJobPath::pulses() const {
    // A pulse a nanometre beyond the end still belongs to it: coordinates are whole 10 nm.
    return static_cast<std::size_t>((to - from + 1e-9) / pitch()) + 1;
}

std::vector<DrawnJobPath> draw(const std::vector<Item>& items) {
    Drawer drawer;
    for (const Item& item : items) {
        drawer.add(item);
    }
    return drawer.take();
}

PulseFigures check_pulses(const std::vector<DrawnJobPath>& job, const std::vector<trace::PulseRecord>& pulses,
                          const PulseCheck& check) {
    PulseFigures out;
    if (check.limits && std::ranges::any_of(pulses, [](const trace::PulseRecord& p) { return p.hit == 0; })) {
        PulseFigures missed;
        const std::vector<trace::PulseRecord> kept = met(pulses, missed);
        out = check_pulses(job, kept, check);
        out.violations += missed.violations;
        out.first.insert(out.first.begin(), missed.first.begin(), missed.first.end());
        out.first.resize(std::min(out.first.size(), kKeptPulseViolations));
        return out;
    }
    double pitch = 0.0;
    for (const DrawnJobPath& path : job) {
        pitch = std::max(pitch, path.pitch());
    }
    const auto parts = split(pulses, kDarkPitches * pitch);
    if (parts.size() != job.size()) {
        if (check.limits) {
            out.pulses = pulses.size();
            keep(out, {.breach = PulseBreach::paths,
                       .value = static_cast<double>(parts.size()),
                       .limit = static_cast<double>(job.size())});
            return out;
        }
        throw std::domain_error("light in " + std::to_string(parts.size()) + " parts, and the job has " +
                                std::to_string(job.size()) + " paths");
    }
    std::vector<std::size_t> judged;
    for (std::size_t i = 0; i < job.size(); ++i) {
        if (!check.only || std::ranges::find(*check.only, job[i].begin.path) != check.only->end()) {
            judged.push_back(i);
        }
    }
    std::size_t count = 0;
    Vec3 sum{};
    for (const std::size_t i : judged) {
        sum = sum + sum_off(job[i], parts[i]);
        count += parts[i].size();
    }
    if (count < 2 * judged.size() || judged.empty()) {
        throw std::domain_error("no pulses to judge");
    }
    out.stand = check.stand ? *check.stand : (1.0 / static_cast<double>(count)) * sum;
    Judge judge(check, out);
    for (const std::size_t i : judged) {
        const auto first = parts[i].first(std::min(parts[i].size(), kStandPulses));
        const double each = 1.0 / static_cast<double>(std::max<std::size_t>(first.size(), 1));
        judge.stretch(job[i], parts[i], check.stand_each ? each * sum_off(job[i], first) : out.stand);
    }
    judge.end();
    return out;
}

void check_gate(std::span<const trace::PulseRecord> pulses, const GateTicks& gate, PulseFigures& figures) {
    for (std::size_t k = 0; k < pulses.size(); ++k) {
        const auto open = [&](std::int64_t t_ns) {
            const std::int64_t place = t_ns / gate.period_ns - 1 - gate.first_tick;
            return place >= 0 && place < std::ssize(gate.open) && gate.open[static_cast<std::size_t>(place)];
        };
        const std::int64_t tick = pulses[k].t_ns / gate.period_ns - 1;
        if (!open(pulses[k].t_ns) && !open(pulses[k].t_ns - kGateSlackNs)) {
            keep(figures, {.breach = PulseBreach::gate_shut,
                           .pulse = k,
                           .t_ns = pulses[k].t_ns,
                           .value = static_cast<double>(tick)});
        }
    }
}

}  // namespace sc::host
