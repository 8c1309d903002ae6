// SPDX-License-Identifier: Apache-2.0
#include "host/verification/burn_finder.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <tuple>

#include "host/calibration/transforms.hpp"
#include "host/verification/stroke_builder.hpp"

namespace sc::host {

namespace {

constexpr double kOverhang = 0.25;  ///< a crossing may lie beyond what is left of a stroke by this part of it

/// Angle by which `a` is ahead of `b`, within ±180 degrees.
double turn_between(double a_deg, double b_deg) noexcept { return std::remainder(a_deg - b_deg, 360.0); }

Vec3 metres(const std::array<std::int64_t, 3>& pm) noexcept {
    return {static_cast<double>(pm[0]) * 1e-12, static_cast<double>(pm[1]) * 1e-12, static_cast<double>(pm[2]) * 1e-12};
}

/// One face's pulses, and the transform to where they lie with the face at its nominal angle.
struct Face {
    double face_deg;
    Rigid<frame::H, frame::T> h_from_table;
    std::vector<SurfacePulse> pulses;
};

Face* face_of(std::vector<Face>& faces, double c_deg, double window_deg) {
    Face* best = nullptr;
    double least = window_deg;
    for (Face& face : faces) {
        const double off = std::abs(turn_between(c_deg, c_of_face(face.face_deg)));
        if (off <= least) {
            least = off;
            best = &face;
        }
    }
    return best;
}

void sort_by_face(std::span<const trace::PulseRecord> pulses, double window_deg, std::vector<Face>& faces,
                  BurnFindings& findings) {
    for (const trace::PulseRecord& record : pulses) {
        if (record.hit != 1) {
            ++findings.missed;
            continue;
        }
        Face* const face = face_of(faces, static_cast<double>(record.c_ndeg) * 1e-9, window_deg);
        if (face == nullptr) {
            ++findings.off_face;
            continue;
        }
        const Vec3 p = (face->h_from_table * Point<frame::T>{metres(record.table_pm)}).v;
        const double focus_y = p.y + static_cast<double>(record.defocus_pm) * 1e-12;
        face->pulses.push_back({record.t_ns, {p.x, p.z}, p.y, focus_y, 1e-3 * record.energy_nj});
    }
}

/// A pair of strokes that may be a cross, and how far its crossing is from their middles.
struct Candidate {
    std::size_t a;
    std::size_t b;
    Flat place;
    double eccentricity;
};

std::optional<double> place_within(const FlatLine& line, const Flat& place) {
    const double half = 0.5 * line.extent();
    const double from_middle = line.along(place) - 0.5 * (line.first + line.last);
    const double part = std::abs(from_middle) / half;
    return part <= 1.0 + 2.0 * kOverhang ? std::optional(part) : std::nullopt;
}

std::optional<Candidate> try_pair(const std::vector<Stroke>& strokes, std::size_t a, std::size_t b,
                                  const BurnFinderSettings& settings) {
    const FlatLine& first = strokes[a].line;
    const FlatLine& second = strokes[b].line;
    if (std::abs(dot(first.direction, second.direction)) > std::sin(settings.right_angle_window)) {
        return std::nullopt;
    }
    const std::optional<Flat> place = meeting_point(first, second);
    if (!place) {
        return std::nullopt;
    }
    const std::optional<double> on_first = place_within(first, *place);
    const std::optional<double> on_second = place_within(second, *place);
    if (!on_first || !on_second) {
        return std::nullopt;
    }
    return Candidate{a, b, *place, *on_first + *on_second};
}

FoundCross make_cross(const std::vector<Stroke>& strokes, const Candidate& pair) {
    const bool a_along_x = std::abs(strokes[pair.a].line.direction.x) >= std::abs(strokes[pair.b].line.direction.x);
    FoundCross found;
    found.stroke_a = a_along_x ? pair.a : pair.b;
    found.stroke_b = a_along_x ? pair.b : pair.a;
    const Stroke& a = strokes[found.stroke_a];
    const Stroke& b = strokes[found.stroke_b];
    const double on_a = a.line.along(pair.place);
    const double on_b = b.line.along(pair.place);
    found.face_deg = a.face_deg;
    found.surface_y = 0.5 * (a.surface_depth.at(on_a) + b.surface_depth.at(on_b));
    found.place = {{pair.place.x, 0.5 * (a.focus_depth.at(on_a) + b.focus_depth.at(on_b)), pair.place.z}};
    const auto sigma = [](const Stroke& stroke) {
        return stroke.line.rms / std::sqrt(static_cast<double>(stroke.pulses - stroke.outliers));
    };
    found.sigma = std::max(sigma(a), sigma(b));
    const double angle = std::acos(std::clamp(std::abs(dot(a.line.direction, b.line.direction)), 0.0, 1.0));
    found.squareness = 0.5 * kPi - angle;
    return found;
}

void pair_strokes(std::size_t first, BurnFindings& findings, const BurnFinderSettings& settings) {
    const std::vector<Stroke>& strokes = findings.strokes;
    std::vector<Candidate> candidates;
    std::vector<bool> taken(strokes.size(), false);
    for (std::size_t a = first; a < strokes.size(); ++a) {
        taken[a] = strokes[a].line.extent() >= settings.long_line;
    }
    for (std::size_t a = first; a < strokes.size(); ++a) {
        for (std::size_t b = a + 1; b < strokes.size() && !taken[a]; ++b) {
            if (!taken[b]) {
                if (const std::optional<Candidate> pair = try_pair(strokes, a, b, settings)) {
                    candidates.push_back(*pair);
                }
            }
        }
    }
    std::ranges::sort(candidates, {}, [](const Candidate& c) { return std::tuple(c.eccentricity, c.a, c.b); });
    std::vector<FoundCross> crosses;
    for (const Candidate& pair : candidates) {
        if (!taken[pair.a] && !taken[pair.b]) {
            taken[pair.a] = taken[pair.b] = true;
            crosses.push_back(make_cross(strokes, pair));
        }
    }
    std::ranges::sort(crosses, {}, [&](const FoundCross& c) {
        return std::tuple(std::min(strokes[c.stroke_a].first_ns, strokes[c.stroke_b].first_ns), c.stroke_a);
    });
    findings.crosses.insert(findings.crosses.end(), crosses.begin(), crosses.end());
    for (std::size_t i = first; i < strokes.size(); ++i) {
        if (!taken[i]) {
            findings.alone.push_back(i);
        }
    }
}

FoundLine make_line(const Stroke& stroke, std::size_t index) {
    const FlatLine& line = stroke.line;
    const bool rising = line.direction.x >= 0.0;
    const double s_from = rising ? line.first : line.last;
    const double s_to = rising ? line.last : line.first;
    const Flat from = line.at(s_from);
    const Flat to = line.at(s_to);
    FoundLine found;
    found.face_deg = stroke.face_deg;
    found.from = {{from.x, stroke.focus_depth.at(s_from), from.z}};
    found.to = {{to.x, stroke.focus_depth.at(s_to), to.z}};
    found.length = norm(found.to.v - found.from.v);
    found.straightness = line.swing;
    found.z_range = stroke.z_max - stroke.z_min;
    found.stroke = index;
    return found;
}

}  // namespace

BurnFindings find_burns(std::span<const trace::PulseRecord> pulses, const AxisLine& axis,
                        std::span<const double> face_angles, const BurnFinderSettings& settings) {
    BurnFindings findings;
    findings.pulses = pulses.size();
    std::vector<Face> faces;
    for (const double face_deg : face_angles) {
        faces.push_back({face_deg, h_from_t(axis, c_of_face(face_deg)), {}});
    }
    sort_by_face(pulses, settings.angle_window_deg, faces, findings);
    for (const Face& face : faces) {
        const std::size_t first = findings.strokes.size();
        StrokeSet set = build_strokes(face.face_deg, face.pulses, settings);
        findings.stray += set.stray;
        std::ranges::move(set.strokes, std::back_inserter(findings.strokes));
        pair_strokes(first, findings, settings);
        for (std::size_t i = first; i < findings.strokes.size(); ++i) {
            if (findings.strokes[i].line.extent() >= settings.long_line) {
                findings.lines.push_back(make_line(findings.strokes[i], i));
            }
        }
    }
    return findings;
}

}  // namespace sc::host
