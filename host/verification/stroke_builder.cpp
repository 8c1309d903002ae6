// SPDX-License-Identifier: Apache-2.0
#include "host/verification/stroke_builder.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace sc::host {

namespace {

constexpr double kBaseForDirection = 0.5e-3;  ///< a shorter run shows no direction yet
constexpr double kPauseFactor = 1.5;          ///< slower than that across a dark stretch is a pause
constexpr double kSamePass = 0.8;             ///< shared part of two passes over one stroke
constexpr double kSharedByResume = 0.1;       ///< shared part of two pieces of one stroke

/// Pulses in order of time that look like one straight stroke, or several such runs joined.
struct Run {
    std::vector<SurfacePulse> pulses;
    FlatLine line;
    double typical_step_ns = 0.0;
    double typical_step = 0.0;
};

double median(std::vector<double> values) {
    if (values.empty()) {
        return 0.0;
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

std::vector<Flat> places_of(const std::vector<SurfacePulse>& pulses) {
    std::vector<Flat> places;
    places.reserve(pulses.size());
    for (const SurfacePulse& pulse : pulses) {
        places.push_back(pulse.place);
    }
    return places;
}

double typical_distance(std::span<const SurfacePulse> pulses) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < pulses.size(); ++i) {
        steps.push_back(length(pulses[i].place - pulses[i - 1].place));
    }
    return median(std::move(steps));
}

/// The next pulse goes on with the run: no gap, and on its line once the run shows one.
bool goes_on(const std::vector<SurfacePulse>& run, const SurfacePulse& next, double gap, double off_line) {
    const Flat step = next.place - run.back().place;
    if (length(step) > gap) {
        return false;
    }
    const Flat base = run.back().place - run.front().place;
    const double extent = length(base);
    if (extent < kBaseForDirection) {
        return true;
    }
    return std::abs(cross((1.0 / extent) * base, next.place - run.front().place)) <= off_line;
}

std::vector<std::vector<SurfacePulse>> cut(std::span<const SurfacePulse> pulses, const BurnFinderSettings& settings) {
    const double gap = std::max(settings.largest_gap, 3.0 * typical_distance(pulses));
    std::vector<std::vector<SurfacePulse>> runs;
    for (const SurfacePulse& pulse : pulses) {
        if (runs.empty() || !goes_on(runs.back(), pulse, gap, settings.off_line)) {
            runs.emplace_back();
        }
        runs.back().push_back(pulse);
    }
    return runs;
}

std::optional<Run> make_run(std::vector<SurfacePulse> pulses) {
    const std::vector<Flat> places = places_of(pulses);
    std::optional<FlatLine> line = places.size() < 2 ? std::nullopt : fit_line(places);
    if (!line) {
        return std::nullopt;
    }
    std::vector<double> steps;
    for (std::size_t i = 1; i < pulses.size(); ++i) {
        steps.push_back(static_cast<double>(pulses[i].t_ns - pulses[i - 1].t_ns));
    }
    const double step = typical_distance(pulses);
    return Run{std::move(pulses), std::move(*line), median(std::move(steps)), step};
}

struct Span {
    double first;
    double last;
};
Span span_on(const FlatLine& line, const Run& run) {
    const double a = line.along(run.line.at(run.line.first));
    const double b = line.along(run.line.at(run.line.last));
    return {std::min(a, b), std::max(a, b)};
}

/// The ends of the shorter run lie on the longer one's line, as nearly as their scatter lets one tell.
bool same_line(const Run& a, const Run& b, double off_line) {
    const double tolerance = std::min(off_line, std::max(20e-6, 6.0 * (a.line.rms + b.line.rms)));
    const FlatLine& longer = a.line.extent() >= b.line.extent() ? a.line : b.line;
    const Run& other = a.line.extent() >= b.line.extent() ? b : a;
    const double first = std::abs(longer.off(other.line.at(other.line.first)));
    const double last = std::abs(longer.off(other.line.at(other.line.last)));
    return std::max(first, last) <= tolerance;
}

/// `b`, burnt after `a`, is a piece of the same stroke: either it touches `a` (a hold in between may have lasted any
/// time), or the beam went on across a dark stretch at its speed.
bool is_continuation(const Run& a, const Run& b, const BurnFinderSettings& settings) {
    const Span sa = span_on(a.line, a);
    const Span sb = span_on(a.line, b);
    const double gap = std::max(sa.first, sb.first) - std::min(sa.last, sb.last);
    const double shorter = std::min(a.line.extent(), b.line.extent());
    if (gap < -kSharedByResume * shorter) {
        return false;
    }
    if (gap <= std::max(0.3e-3, 5.0 * a.typical_step)) {
        return true;
    }
    const double pause = static_cast<double>(b.pulses.front().t_ns - a.pulses.back().t_ns);
    const double way_time = a.typical_step > 0.0 ? gap / a.typical_step * a.typical_step_ns : 0.0;
    return gap <= settings.unlit_gap && pause > 0.0 && pause <= kPauseFactor * way_time + 2.0 * a.typical_step_ns;
}

bool is_another_pass(const Run& a, const Run& b) {
    const Span sa = span_on(a.line, a);
    const Span sb = span_on(a.line, b);
    const double shared = std::min(sa.last, sb.last) - std::max(sa.first, sb.first);
    return shared >= kSamePass * std::max(sa.last - sa.first, sb.last - sb.first);
}

/// Joins runs for which `belong(earlier, later)` holds, until none is left.
template <class Belong>
void join(std::vector<Run>& runs, double off_line, Belong belong) {
    for (std::size_t i = 0; i < runs.size(); ++i) {
        for (std::size_t j = i + 1; j < runs.size();) {
            if (!same_line(runs[i], runs[j], off_line) || !belong(runs[i], runs[j])) {
                ++j;
                continue;
            }
            std::vector<SurfacePulse> both = std::move(runs[i].pulses);
            both.insert(both.end(), runs[j].pulses.begin(), runs[j].pulses.end());
            runs[i] = *make_run(std::move(both));
            runs.erase(runs.begin() + static_cast<std::ptrdiff_t>(j));
            j = i + 1;
        }
    }
}

Stroke make_stroke(double face_deg, const Run& run) {
    std::vector<double> s;
    std::vector<double> surface;
    std::vector<double> focus;
    double energy = 0.0;
    for (const SurfacePulse& pulse : run.pulses) {
        s.push_back(run.line.along(pulse.place));
        surface.push_back(pulse.surface_y);
        focus.push_back(pulse.focus_y);
        energy += pulse.energy_uj;
    }
    Stroke stroke;
    stroke.face_deg = face_deg;
    stroke.line = run.line;
    stroke.surface_depth = fit_trend(s, surface, run.line.counts);
    stroke.focus_depth = fit_trend(s, focus, run.line.counts);
    stroke.z_min = stroke.z_max = run.line.point.z;
    for (std::size_t i = 0; i < run.pulses.size(); ++i) {
        if (run.line.counts[i]) {
            stroke.z_min = std::min(stroke.z_min, run.pulses[i].place.z);
            stroke.z_max = std::max(stroke.z_max, run.pulses[i].place.z);
        }
    }
    stroke.outliers = static_cast<std::size_t>(std::ranges::count(run.line.counts, false));
    stroke.pulses = run.pulses.size();
    stroke.energy_uj = energy / static_cast<double>(run.pulses.size());
    stroke.first_ns = run.pulses.front().t_ns;
    stroke.last_ns = run.pulses.back().t_ns;
    return stroke;
}

}  // namespace

StrokeSet build_strokes(double face_deg, std::span<const SurfacePulse> pulses, const BurnFinderSettings& settings) {
    StrokeSet set;
    std::vector<Run> runs;
    for (std::vector<SurfacePulse>& part : cut(pulses, settings)) {
        const std::size_t size = part.size();
        std::optional<Run> run = make_run(std::move(part));
        if (run && size >= settings.fewest_pulses && run->line.extent() >= settings.shortest) {
            runs.push_back(std::move(*run));
        } else {
            set.stray += size;
        }
    }
    const double off_line = settings.off_line;
    join(runs, off_line, [&](const Run& a, const Run& b) { return is_continuation(a, b, settings); });
    join(runs, off_line, [](const Run& a, const Run& b) { return is_another_pass(a, b); });
    for (const Run& run : runs) {
        set.strokes.push_back(make_stroke(face_deg, run));
    }
    return set;
}

}  // namespace sc::host
