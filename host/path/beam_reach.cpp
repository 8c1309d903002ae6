// SPDX-License-Identifier: Apache-2.0
#include "host/path/beam_reach.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "host/calibration/transforms.hpp"

namespace sc::host {

namespace {

constexpr double kCell = 0.4e-3;     ///< metres
constexpr double kStep = 1e-3;       ///< metres along a line between questions
constexpr double kSamePlace = 1e-6;  ///< metres: a path must not repeat a place
constexpr double kEdge = 0.1e-3;     ///< metres left out before an edge
constexpr double kSmooth = 0.9;      ///< cosine between normals: less is an edge
constexpr float kNothing = -std::numeric_limits<float>::infinity();

double degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

/// A line with places at least every kStep; `original` says which of them it had before.
struct FineLine {
    std::vector<SurfacePlace> places;
    std::vector<bool> original;
};
FineLine refined(std::span<const SurfacePlace> places, bool closed) {
    FineLine out;
    for (std::size_t i = 0; i < places.size(); ++i) {
        out.places.push_back(places[i]);
        out.original.push_back(true);
        if (i + 1 == places.size() && !closed) {
            break;
        }
        const SurfacePlace& a = places[i];
        const SurfacePlace& b = places[(i + 1) % places.size()];
        const auto count = static_cast<int>(std::ceil(norm(b.place - a.place) / kStep));
        for (int k = 1; k < count; ++k) {
            const double share = static_cast<double>(k) / count;
            const Vec3 normal = (1.0 - share) * a.normal + share * b.normal;
            out.places.push_back({a.place + share * (b.place - a.place), (1.0 / norm(normal)) * normal});
            out.original.push_back(false);
        }
    }
    if (closed && !places.empty()) {
        out.places.push_back(places.front());
        out.original.push_back(true);
    }
    return out;
}

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
void trim(std::vector<ReachedPiece>& pieces) {
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
            shorten(pieces[i].places, kEdge);
        }
        if (cut[i].first) {
            std::ranges::reverse(pieces[i].places);
            shorten(pieces[i].places, kEdge);
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
    }
    return "?";
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
    const double widest = options_.beam_radius + options_.beam_opening * std::max(0.0, view.top - place.y);
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
            if (above > rise * (beside + kCell) + kCell &&
                beside < options_.beam_radius + options_.beam_opening * above) {
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

std::size_t BeamReach::reached_to(std::span<const SurfacePlace> places, std::size_t begin, std::size_t face) const {
    std::size_t end = begin;
    while (end < places.size() && at(places[end], face) == Unreached::none) {
        ++end;
    }
    return end;
}

SplitLine BeamReach::split(std::span<const SurfacePlace> places, bool closed) const {
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
    std::size_t begin = 0;
    while (begin + 1 < fine.size()) {
        std::size_t best = 0;
        std::size_t end = begin;
        for (std::size_t face = 0; face < views_.size(); ++face) {
            const std::size_t to = reached_to(fine, begin, face);
            const bool straighter = to == end && incidence_deg(fine[begin], face) < incidence_deg(fine[begin], best);
            if (to > end || straighter) {
                end = to;
                best = face;
            }
        }
        if (end <= begin + 1) {
            std::size_t looks = 0;
            for (std::size_t face = 1; face < views_.size(); ++face) {
                looks = incidence_deg(fine[begin], face) < incidence_deg(fine[begin], looks) ? face : looks;
            }
            const Unreached why = at(fine[begin], looks);
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
    trim(out.reached);
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
