// SPDX-License-Identifier: Apache-2.0
#include "host/verification/pulse_checker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>

namespace sc::host {
namespace {

/// Two pulses further apart than this belong to different paths: a jump with its run-out and run-in takes longer, and
/// the slowest mark has its next pulse sooner.
constexpr std::int64_t kDarkNs = 2'500'000;
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
std::vector<std::span<const trace::PulseRecord>> split(std::span<const trace::PulseRecord> pulses) {
    std::vector<std::span<const trace::PulseRecord>> parts;
    std::size_t begin = 0;
    for (std::size_t i = 1; i <= pulses.size(); ++i) {
        if (i == pulses.size() || pulses[i].t_ns - pulses[i - 1].t_ns > kDarkNs) {
            parts.push_back(pulses.subspan(begin, i - begin));
            begin = i;
        }
    }
    return parts;
}

/// Sums over pulses of all judged paths.
struct Sums {
    double place_square = 0.0;
    double pitch_square = 0.0;
    std::size_t pitches = 0;
};

void judge(const DrawnJobPath& path, std::span<const trace::PulseRecord> pulses, Sums& sums, PulseFigures& out) {
    const double pitch = path.pitch();
    const double energy = path.begin.energy_nj;
    const std::size_t expected = path.pulses();
    out.pulses += pulses.size();
    out.lost += pulses.size() > expected ? pulses.size() - expected : expected - pulses.size();
    std::vector<double> along;
    along.reserve(pulses.size());
    for (std::size_t k = 0; k < pulses.size(); ++k) {
        const Vec3 place = place_of(pulses[k]) - out.stand;
        const double off = apart(place, path.path.at(static_cast<double>(k) * pitch));
        sums.place_square += off * off;
        out.placement_peak = std::max(out.placement_peak, off);
        // From the pulse before, so that a path that crosses itself is not mistaken.
        const double from = along.empty() ? -pitch : along.back();
        along.push_back(path.path.nearest(place, from - pitch, from + 3.0 * pitch));
        out.energy_peak = std::max(out.energy_peak, std::abs(pulses[k].energy_nj / energy - 1.0));
        if (k > 0) {
            const double error = (along[k] - along[k - 1]) / pitch - 1.0;
            sums.pitch_square += error * error;
            ++sums.pitches;
            out.pitch_peak = std::max(out.pitch_peak, std::abs(error));
        }
    }
    const auto window = static_cast<std::size_t>(std::lround(kPerMillimetre / pitch));
    double light = 0.0;
    for (std::size_t k = 0; k < pulses.size(); ++k) {
        light += pulses[k].energy_nj;
        if (k < window) {
            continue;
        }
        light -= pulses[k - window].energy_nj;
        const double per_length = light / (along[k] - along[k - window]);
        out.energy_per_length_peak = std::max(out.energy_per_length_peak, std::abs(per_length * pitch / energy - 1.0));
    }
    if (!pulses.empty()) {
        const double counted = static_cast<double>(pulses.size() - 1) * pitch;
        const double along_path =
            path.path.nearest(place_of(pulses.back()) - out.stand, counted - 50.0 * pitch, counted + 50.0 * pitch);
        out.drift = std::max({out.drift, std::round(std::abs(along_path - counted) / pitch),
                              std::abs(static_cast<double>(pulses.size()) - static_cast<double>(expected))});
    }
}

}  // namespace

void DrawnPath::begin(const PathPoint& point) { last_ = place_of(point); }

void DrawnPath::line_to(const PathPoint& point) {
    const Vec3 to = place_of(point);
    const double length = apart(last_, to);
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
        return (place.x - span.from.x) * span.way.x + (place.z - span.from.z) * span.way.z;
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

std::size_t DrawnJobPath::pulses() const {
    // A pulse a nanometre beyond the end still belongs to it: coordinates are whole 10 nm.
    return static_cast<std::size_t>((path.length() + 1e-9) / pitch()) + 1;
}

std::vector<DrawnJobPath> draw(const std::vector<Item>& items) {
    std::vector<DrawnJobPath> paths;
    bool first = true;
    for (const Item& item : items) {
        if (const auto* begin = std::get_if<PathBegin>(&item)) {
            paths.push_back({*begin, {}});
            first = true;
        } else if (const auto* point = std::get_if<PathPoint>(&item)) {
            first ? paths.back().path.begin(*point) : paths.back().path.line_to(*point);
            first = false;
        } else if (const auto* arc = std::get_if<PathArc>(&item)) {
            paths.back().path.arc(arc->via, arc->to);
        } else if (std::holds_alternative<PathEnd>(item) && !(paths.back().path.length() > 0.0)) {
            throw std::domain_error("path " + std::to_string(paths.back().begin.path) + " has no length");
        }
    }
    return paths;
}

PulseFigures check_pulses(const std::vector<DrawnJobPath>& job, const std::vector<trace::PulseRecord>& pulses,
                          const PulseCheck& check) {
    const auto parts = split(pulses);
    if (parts.size() != job.size()) {
        throw std::domain_error("light in " + std::to_string(parts.size()) + " parts, and the job has " +
                                std::to_string(job.size()) + " paths");
    }
    std::vector<std::size_t> judged;
    for (std::size_t i = 0; i < job.size(); ++i) {
        if (!check.only || std::ranges::find(*check.only, job[i].begin.path) != check.only->end()) {
            judged.push_back(i);
        }
    }
    PulseFigures out;
    Vec3 sum{};
    for (const std::size_t i : judged) {
        for (std::size_t k = 0; k < parts[i].size(); ++k) {
            sum = sum + (place_of(parts[i][k]) - job[i].path.at(static_cast<double>(k) * job[i].pitch()));
        }
        out.pulses += parts[i].size();
    }
    if (out.pulses < 2 * judged.size() || judged.empty()) {
        throw std::domain_error("no pulses to judge");
    }
    out.stand = check.stand ? *check.stand : (1.0 / static_cast<double>(out.pulses)) * sum;
    out.pulses = 0;
    Sums sums;
    for (const std::size_t i : judged) {
        judge(job[i], parts[i], sums, out);
    }
    out.placement_rms = std::sqrt(sums.place_square / static_cast<double>(out.pulses));
    out.pitch_rms = std::sqrt(sums.pitch_square / static_cast<double>(std::max<std::size_t>(sums.pitches, 1)));
    return out;
}

}  // namespace sc::host
