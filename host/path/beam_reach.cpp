// SPDX-License-Identifier: Apache-2.0
#include "host/path/beam_reach.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "host/calibration/transforms.hpp"

namespace sc::host {

namespace {

constexpr double kCell = 0.4e-3;      ///< metres
constexpr double kStep = 0.5e-3;      ///< metres along a line between questions
constexpr double kSamePlace = 1e-6;   ///< metres: a path must not repeat a place
constexpr double kSmooth = 0.9;       ///< cosine between normals: less is an edge
constexpr double kStepHeight = 3e-3;  ///< metres: what stands so far before a place is another part of the metal
constexpr double kAlong = 0.01;       ///< sine of the angle between beam and plane: less is along it
constexpr float kNothing = -std::numeric_limits<float>::infinity();

double degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

/// Takes a little off the end of a piece.
void shorten(std::vector<SurfacePlace>& places, double by) {
    while (places.size() > 2 && norm(places.back().place - places[places.size() - 2].place) <= by) {
        by -= norm(places.back().place - places[places.size() - 2].place);
        places.pop_back();
    }
    const SurfacePlace& before = places[places.size() - 2];
    const Vec3 way = places.back().place - before.place;
    const double length = norm(way);
    if (length > by) {
        places.back().place = before.place + ((length - by) / length) * way;
    }
}

double length_of(std::span<const SurfacePlace> places) {
    double sum = 0.0;
    for (std::size_t i = 1; i < places.size(); ++i) {
        sum += norm(places[i].place - places[i - 1].place);
    }
    return sum;
}

/// At an edge a beam that is off by a few micrometres passes the metal by and marks what lies behind: pieces end a
/// little before it. Where one smoothly goes on into the next nothing is taken.
void trim(std::vector<ReachedPiece>& pieces, double edge) {
    const auto goes_on = [](const ReachedPiece& a, const ReachedPiece& b) {
        return norm(a.places.back().place - b.places.front().place) < kSamePlace &&
               dot(a.places[a.places.size() - 2].normal, b.places[1].normal) > kSmooth;
    };
    std::vector<std::pair<bool, bool>> cut;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const ReachedPiece& last = pieces[(i + pieces.size() - 1) % pieces.size()];
        const ReachedPiece& next = pieces[(i + 1) % pieces.size()];
        cut.push_back({!goes_on(last, pieces[i]), !goes_on(pieces[i], next)});
    }
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        if (cut[i].second) {
            shorten(pieces[i].places, edge);
        }
        if (cut[i].first) {
            std::ranges::reverse(pieces[i].places);
            shorten(pieces[i].places, edge);
            std::ranges::reverse(pieces[i].places);
        }
        pieces[i].length = length_of(pieces[i].places);
    }
}

}  // namespace

std::string_view name_of(Unreached why) noexcept {
    switch (why) {
        case Unreached::none: return "reached";
        case Unreached::incidence: return "the beam meets the surface too flat";
        case Unreached::travel: return "out of the axes' travel";
        case Unreached::keep_out: return "in a keep-out volume";
        case Unreached::occluded: return "other metal stands in the beam";
        case Unreached::too_short: return "too short a piece";
        case Unreached::edge: return "too near an edge";
        case Unreached::unsure: return "the scan is too poor there to mark the plane";
    }
    return "?";
}

std::vector<double> faces_along(const CalibrationSet& calibration, const Vec3& normal) {
    // Turned by a face, the normal's component along the beam is middle + even · cos + odd · sin.
    const auto along_beam = [&](double face) {
        const Vec3 origin = to_face(calibration, Point<frame::C>{{}}, face).v;
        return (to_face(calibration, Point<frame::C>{normal}, face).v - origin).y;
    };
    const double middle = 0.5 * (along_beam(0.0) + along_beam(180.0));
    const double even = 0.5 * (along_beam(0.0) - along_beam(180.0));
    const double odd = along_beam(90.0) - middle;
    const double swing = std::hypot(even, odd);
    if (swing < kAlong || std::abs(middle) > swing) {
        return {};
    }
    const auto rounded = [](double radians) {
        return std::round(100.0 * degrees(std::remainder(radians, 2.0 * std::numbers::pi))) / 100.0;
    };
    const double at = std::atan2(odd, even);
    const double half = std::acos(-middle / swing);
    return {rounded(at - half), rounded(at + half)};
}

BeamReach::BeamReach(const CalibrationSet& calibration, const MachineConfig& machine, std::span<const Vec3> cloud,
                     const ReachOptions& options)
    : machine_(machine), options_(options) {
    for (const double face : options_.faces) {
        const Vec3 origin = to_face(calibration, Point<frame::C>{{}}, face).v;
        const Vec3 x = to_face(calibration, Point<frame::C>{{1.0, 0.0, 0.0}}, face).v - origin;
        const Vec3 y = to_face(calibration, Point<frame::C>{{0.0, 1.0, 0.0}}, face).v - origin;
        const Vec3 z = to_face(calibration, Point<frame::C>{{0.0, 0.0, 1.0}}, face).v - origin;
        View view;
        view.h_from_c = {Mat3{{x, y, z}}.transposed(), origin};
        fill(view, cloud);
        views_.push_back(std::move(view));
    }
}

void BeamReach::fill(View& view, std::span<const Vec3> cloud) const {
    if (cloud.empty()) {
        return;
    }
    std::vector<Vec3> places;
    places.reserve(cloud.size());
    Vec3 low = (view.h_from_c * Point<frame::C>{cloud.front()}).v;
    Vec3 high = low;
    for (const Vec3& p : cloud) {
        const Vec3 q = (view.h_from_c * Point<frame::C>{p}).v;
        low = {std::min(low.x, q.x), 0.0, std::min(low.z, q.z)};
        high = {std::max(high.x, q.x), std::max(high.y, q.y), std::max(high.z, q.z)};
        places.push_back(q);
    }
    view.x = low.x;
    view.z = low.z;
    view.top = high.y;
    view.columns = static_cast<std::size_t>((high.x - low.x) / kCell) + 1;
    view.rows = static_cast<std::size_t>((high.z - low.z) / kCell) + 1;
    view.highest.assign(view.columns * view.rows, kNothing);
    for (const Vec3& q : places) {
        const auto column = static_cast<std::size_t>((q.x - low.x) / kCell);
        const auto row = static_cast<std::size_t>((q.z - low.z) / kCell);
        float& cell = view.highest[row * view.columns + column];
        cell = std::max(cell, static_cast<float>(q.y));
    }
}

bool BeamReach::hidden(const View& view, const Vec3& place) const {
    const double widest =
        options_.beam_radius + options_.unseen_rim + options_.beam_opening * std::max(0.0, view.top - place.y);
    const auto at = [](double value, double from, std::size_t count) {
        return static_cast<std::size_t>(std::clamp((value - from) / kCell, 0.0, static_cast<double>(count) - 1.0));
    };
    if (view.highest.empty()) {
        return false;
    }
    // Beside the beam the surface itself may rise, as steeply as the largest incidence allows, and a cell more.
    const double rise = std::tan(options_.incidence_deg * std::numbers::pi / 180.0);
    for (std::size_t row = at(place.z - widest, view.z, view.rows); row <= at(place.z + widest, view.z, view.rows);
         ++row) {
        for (std::size_t column = at(place.x - widest, view.x, view.columns);
             column <= at(place.x + widest, view.x, view.columns); ++column) {
            const double above = static_cast<double>(view.highest[row * view.columns + column]) - place.y;
            const double dx = view.x + (static_cast<double>(column) + 0.5) * kCell - place.x;
            const double dz = view.z + (static_cast<double>(row) + 0.5) * kCell - place.z;
            const double beside = std::hypot(dx, dz);
            const double rim = above > kStepHeight ? options_.unseen_rim : 0.0;
            if (above > rise * (beside + kCell) + kCell &&
                beside < options_.beam_radius + rim + options_.beam_opening * above) {
                return true;
            }
        }
    }
    return false;
}

Vec3 BeamReach::in_h(const Vec3& place, std::size_t face) const {
    return (views_.at(face).h_from_c * Point<frame::C>{place}).v;
}

double BeamReach::incidence_deg(const SurfacePlace& place, std::size_t face) const {
    const Vec3 normal = views_.at(face).h_from_c.rotation * place.normal;
    return degrees(std::acos(std::clamp(normal.y, -1.0, 1.0)));
}

Unreached BeamReach::at(const SurfacePlace& place, std::size_t face) const {
    if (incidence_deg(place, face) > options_.incidence_deg) {
        return Unreached::incidence;
    }
    const Vec3 h = in_h(place.place, face);
    for (std::size_t i = 0; i < 3; ++i) {
        if (h[i] < machine_.axis[i].travel_min + options_.room || h[i] > machine_.axis[i].travel_max - options_.room) {
            return Unreached::travel;
        }
    }
    for (std::size_t k = 0; k < std::min<std::size_t>(machine_.keep_out_count, kKeepOutCapacity); ++k) {
        const KeepOut& box = machine_.keep_out[k];
        bool within = true;
        for (std::size_t i = 0; i < 3; ++i) {
            within = within && h[i] > box.min[i] - options_.room && h[i] < box.max[i] + options_.room;
        }
        if (within) {
            return Unreached::keep_out;
        }
    }
    return hidden(views_[face], h) ? Unreached::occluded : Unreached::none;
}

BeamReach::FineLine BeamReach::refined(std::span<const SurfacePlace> places, bool closed) const {
    FineLine out;
    std::vector<std::pair<std::size_t, std::size_t>> edges;  // the places before and behind
    for (std::size_t i = 0; i < places.size(); ++i) {
        out.places.push_back(places[i]);
        out.original.push_back(true);
        if (i + 1 == places.size() && !closed) {
            break;
        }
        const SurfacePlace& a = places[i];
        const SurfacePlace& b = places[(i + 1) % places.size()];
        const auto count = std::max(1, static_cast<int>(std::ceil(norm(b.place - a.place) / kStep)));
        if (dot(a.normal, b.normal) < kSmooth) {
            edges.emplace_back(out.places.size() - 1, out.places.size() - 1 + static_cast<std::size_t>(count));
        }
        for (int k = 1; k < count; ++k) {
            const double share = static_cast<double>(k) / count;
            const Vec3 normal = (1.0 - share) * a.normal + share * b.normal;
            out.places.push_back(
                {a.place + share * (b.place - a.place), (1.0 / norm(normal)) * normal, std::max(a.sigma, b.sigma)});
            out.original.push_back(false);
        }
    }
    if (closed && !places.empty()) {
        out.places.push_back(places.front());
        out.original.push_back(true);
    }
    out.corner.assign(out.places.size(), false);
    for (const auto& [before, behind] : edges) {
        for (std::size_t i = 0; i < out.places.size(); ++i) {
            const double near = std::min(norm(out.places[i].place - out.places[before].place),
                                         norm(out.places[i].place - out.places[behind].place));
            out.corner[i] = out.corner[i] || near < options_.edge || (i > before && i < behind);
        }
    }
    return out;
}

Unreached BeamReach::why_not(const FineLine& line, std::size_t i, std::size_t face, double sway) const {
    const auto& places = line.places;
    if (const Unreached why = at(places[i], face); why != Unreached::none) {
        return why;
    }
    // The line itself may run into depth faster than the normals say, which are averages over a reach: at an edge.
    const double angle = options_.incidence_deg * std::numbers::pi / 180.0;
    const auto steep = [&](std::size_t a, std::size_t b) {
        const Vec3 way = places[b].place - places[a].place;
        return std::abs((views_[face].h_from_c.rotation * way).y) > std::sin(angle) * norm(way);
    };
    if ((i > 0 && steep(i - 1, i)) || (i + 1 < places.size() && steep(i, i + 1))) {
        return Unreached::edge;
    }
    if (sway < kAlong) {
        return Unreached::none;
    }
    const double leaning = std::cos(incidence_deg(places[i], face) * std::numbers::pi / 180.0);
    if (3.0 * places[i].sigma * sway > options_.off_plane * leaning) {
        return Unreached::unsure;
    }
    return line.corner[i] ? Unreached::edge : Unreached::none;
}

BeamReach::Reached BeamReach::reached(const FineLine& line, const Vec3& normal) const {
    Reached out;
    const std::span<const SurfacePlace> places = line.places;
    out.kept.assign(places.size(), false);
    for (std::size_t face = 0; face < views_.size(); ++face) {
        const double sway = std::abs((views_[face].h_from_c.rotation * normal).y);
        const bool along = sway < kAlong && dot(normal, normal) > 0.0;
        std::vector<Unreached> by(places.size());
        std::size_t begin = 0;
        for (std::size_t i = 0; i <= places.size(); ++i) {
            if (i < places.size()) {
                by[i] = why_not(line, i, face, sway);
                if (by[i] == Unreached::none) {
                    continue;
                }
            }
            if (along && i > begin && length_of(places.subspan(begin, i - begin)) >= options_.least_length) {
                std::fill(out.kept.begin() + static_cast<std::ptrdiff_t>(begin),
                          out.kept.begin() + static_cast<std::ptrdiff_t>(i), true);
            }
            begin = i + 1;
        }
        out.along.push_back(along);
        out.by.push_back(std::move(by));
    }
    return out;
}

std::size_t BeamReach::Reached::to(std::size_t begin, std::size_t face) const {
    std::size_t end = begin;
    while (end < kept.size() && by[face][end] == Unreached::none) {
        ++end;
        if (!along[face] && end > begin + 1 && kept[end - 1]) {
            break;
        }
    }
    return !along[face] && end > begin + 1 && kept[begin] && kept[begin + 1] ? begin : end;
}

std::pair<std::size_t, std::size_t> BeamReach::farthest(const Reached& faces, std::size_t begin,
                                                        const SurfacePlace& place) const {
    std::size_t best = 0;
    std::size_t end = begin;
    for (std::size_t face = 0; face < views_.size(); ++face) {
        const std::size_t to = faces.to(begin, face);
        if (to > end || (to == end && incidence_deg(place, face) < incidence_deg(place, best))) {
            end = to;
            best = face;
        }
    }
    return {best, end};
}

std::size_t BeamReach::straightest(const SurfacePlace& place) const {
    std::size_t out = 0;
    for (std::size_t face = 1; face < views_.size(); ++face) {
        out = incidence_deg(place, face) < incidence_deg(place, out) ? face : out;
    }
    return out;
}

SplitLine BeamReach::split(std::span<const SurfacePlace> places, bool closed, const Vec3& normal) const {
    SplitLine out;
    const FineLine line = refined(places, closed);
    const auto& fine = line.places;
    const auto miss = [&](std::size_t first, std::size_t last, Unreached why) {
        const Vec3 from = fine[first].place;
        const Vec3 to = fine[std::min(last, fine.size() - 1)].place;
        const double length = length_of(std::span(fine).subspan(first, std::min(last, fine.size() - 1) - first + 1));
        if (!out.missed.empty() && out.missed.back().why == why && norm(out.missed.back().to - from) < kSamePlace) {
            out.missed.back().to = to;
            out.missed.back().length += length;
        } else if (length > 0.0) {
            out.missed.push_back({from, to, length, why});
        }
    };
    const Reached faces = reached(line, normal);
    std::size_t begin = 0;
    while (begin + 1 < fine.size()) {
        const auto [best, end] = farthest(faces, begin, fine[begin]);
        if (end <= begin + 1) {
            const std::size_t looks = straightest(fine[begin]);
            const auto& by = faces.by[looks];
            const Unreached why = by[begin] == Unreached::none ? by[begin + 1] : by[begin];
            miss(begin, begin + 1, why == Unreached::none ? Unreached::too_short : why);
            ++begin;
            continue;
        }
        ReachedPiece piece{.face_deg = options_.faces[best], .places = {}, .length = 0.0, .worst_incidence_deg = 0.0};
        for (std::size_t i = begin; i < end; ++i) {
            const bool end_place = i == begin || i + 1 == end;
            if ((line.original[i] || end_place) &&
                (piece.places.empty() || norm(fine[i].place - piece.places.back().place) > kSamePlace)) {
                piece.places.push_back(fine[i]);
            }
            piece.worst_incidence_deg = std::max(piece.worst_incidence_deg, incidence_deg(fine[i], best));
        }
        piece.length = length_of(piece.places);
        if (piece.length < options_.least_length) {
            miss(begin, end - 1, Unreached::too_short);
        } else {
            out.reached.push_back(std::move(piece));
        }
        begin = end - 1;
    }
    trim(out.reached, options_.edge);
    // Where a closed line was begun need not stay an end.
    if (closed && out.reached.size() > 1 && out.reached.front().face_deg == out.reached.back().face_deg &&
        norm(out.reached.front().places.front().place - out.reached.back().places.back().place) < kSamePlace) {
        ReachedPiece& first = out.reached.front();
        ReachedPiece& last = out.reached.back();
        last.places.insert(last.places.end(), first.places.begin() + 1, first.places.end());
        last.length += first.length;
        last.worst_incidence_deg = std::max(last.worst_incidence_deg, first.worst_incidence_deg);
        out.reached.erase(out.reached.begin());
    }
    return out;
}

}  // namespace sc::host
