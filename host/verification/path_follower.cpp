// SPDX-License-Identifier: Apache-2.0
#include "host/verification/path_follower.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/calibration/transforms.hpp"

namespace sc::host {

namespace {

constexpr double kSameFaceDeg = 1.0;
constexpr double kDark = 0.5e-3;             ///< metres between pulses, or three pitches: another run
constexpr std::int64_t kDarkNs = 5'000'000;  ///< or that long
constexpr double kDarkCorner = 0.3e-3;       ///< metres; where the beam stops it is dark until it is fast enough again
constexpr std::size_t kPiecesOfBlock = 32;
constexpr std::size_t kProbes = 32;  ///< pulses of a run by which its path is found

/// Pieces with boxes around blocks of them, for the one next to a place.
class Route {
public:
    explicit Route(const PlannedPath& path) {
        for (const std::vector<Piece>& stroke : strokes_of(path)) {
            pieces_.insert(pieces_.end(), stroke.begin(), stroke.end());
        }
        starts_.push_back(0.0);
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            const Bounds bounds = bounds_of(pieces_[i]);
            if (i % kPiecesOfBlock == 0) {
                blocks_.push_back(bounds);
            } else {
                blocks_.back().take(bounds);
            }
            starts_.push_back(starts_.back() + pieces_[i].length());
        }
    }

    struct Place {
        double distance = std::numeric_limits<double>::infinity();
        double station = 0.0;
    };
    /// Blocks are tried from where the last place was.
    [[nodiscard]] Place place_of(const Vec3& at) {
        Place best;
        std::size_t best_block = last_;
        for (std::size_t k = 0; k < blocks_.size(); ++k) {
            const std::size_t block = (last_ + k) % blocks_.size();
            if (blocks_[block].distance(at) >= best.distance) {
                continue;
            }
            const std::size_t end = std::min(pieces_.size(), (block + 1) * kPiecesOfBlock);
            for (std::size_t i = block * kPiecesOfBlock; i < end; ++i) {
                const Nearest here = nearest(pieces_[i], at);
                if (here.distance < best.distance) {
                    best = {here.distance, starts_[i] + here.share * (starts_[i + 1] - starts_[i])};
                    best_block = block;
                }
            }
        }
        last_ = best_block;
        return best;
    }
    [[nodiscard]] double length() const noexcept { return starts_.back(); }

private:
    std::vector<Piece> pieces_;
    std::vector<Bounds> blocks_;
    std::vector<double> starts_;
    std::size_t last_ = 0;
};

struct Candidate {
    const PlannedPath* path;
    Route route;
    std::vector<Route::Place> places;  ///< of its pulses; free paths only
};

struct Shot {
    std::size_t record;
    std::int64_t t_ns;
    Vec3 place;
};

/// The shots of one face with the paths planned there.
class Follower {
public:
    Follower(const JobPlan& plan, double face_deg, double radius) : radius_(radius) {
        for (const PlannedPath& path : plan.paths) {
            if (std::abs(path.face_deg - face_deg) < 1e-6) {
                candidates_.push_back({&path, Route(path), {}});
                dark_ = std::max(dark_, 3.0 * path.settings.pitch.si());
            }
        }
    }

    /// Marks the records that belong to free paths.
    void follow(const std::vector<Shot>& shots, std::vector<bool>& taken) {
        for (std::size_t first = 0; first < shots.size();) {
            std::size_t end = first + 1;
            while (end < shots.size() && norm(shots[end].place - shots[end - 1].place) <= dark_ &&
                   shots[end].t_ns - shots[end - 1].t_ns <= kDarkNs) {
                ++end;
            }
            give(std::span(shots).subspan(first, end - first), taken);
            first = end;
        }
    }

    void report(std::vector<PathAccuracy>& out) {
        for (Candidate& candidate : candidates_) {
            if (candidate.path->kind == PathKind::free_path) {
                out.push_back(judge(candidate));
            }
        }
    }

private:
    void give(std::span<const Shot> run, std::vector<bool>& taken) {
        Candidate* best = nullptr;
        double least = std::numeric_limits<double>::infinity();
        const std::size_t step = 1 + run.size() / kProbes;
        for (Candidate& candidate : candidates_) {
            double squares = 0.0;
            double count = 0.0;
            for (std::size_t i = 0; i < run.size(); i += step) {
                const double off = candidate.route.place_of(run[i].place).distance;
                squares += off * off;
                count += 1.0;
            }
            const double rms = std::sqrt(squares / count);
            if (rms < least) {
                least = rms;
                best = &candidate;
            }
        }
        if (best == nullptr || best->path->kind != PathKind::free_path || least > radius_) {
            return;
        }
        for (const Shot& shot : run) {
            best->places.push_back(best->route.place_of(shot.place));
            taken[shot.record] = true;
        }
    }

    static PathAccuracy judge(Candidate& candidate) {
        const PlannedPath& path = *candidate.path;
        PathAccuracy out{.path = path.id, .name = path.name, .face_deg = path.face_deg};
        std::vector<Route::Place>& places = candidate.places;
        out.pulses = places.size();
        double squares = 0.0;
        for (const Route::Place& place : places) {
            out.max = std::max(out.max, place.distance);
            squares += place.distance * place.distance;
        }
        out.rms = places.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(places.size()));
        std::ranges::sort(places, {}, &Route::Place::station);
        double last = 0.0;
        for (const Route::Place& place : places) {
            out.largest_gap = std::max(out.largest_gap, place.station - last);
            last = place.station;
        }
        out.largest_gap = std::max(out.largest_gap, candidate.route.length() - last);
        out.whole = out.largest_gap <= std::max(kDarkCorner, 3.0 * path.settings.pitch.si());
        return out;
    }

    double radius_;
    double dark_ = kDark;
    std::vector<Candidate> candidates_;
};

Vec3 metres(const std::array<std::int64_t, 3>& pm) noexcept {
    return {static_cast<double>(pm[0]) * 1e-12, static_cast<double>(pm[1]) * 1e-12, static_cast<double>(pm[2]) * 1e-12};
}

std::vector<Shot> shots_on(double face_deg, std::span<const trace::PulseRecord> pulses, const AxisLine& axis) {
    const auto h_from_table = h_from_t(axis, c_of_face(face_deg));
    std::vector<Shot> shots;
    for (std::size_t i = 0; i < pulses.size(); ++i) {
        const trace::PulseRecord& record = pulses[i];
        const double off = std::remainder(static_cast<double>(record.c_ndeg) * 1e-9 - c_of_face(face_deg), 360.0);
        if (record.hit != 0 && std::abs(off) <= kSameFaceDeg) {
            Vec3 place = (h_from_table * Point<frame::T>{metres(record.table_pm)}).v;
            place.y += static_cast<double>(record.defocus_pm) * 1e-12;
            shots.push_back({i, record.t_ns, place});
        }
    }
    return shots;
}

}  // namespace

FollowedPaths follow_paths(std::span<const trace::PulseRecord> pulses, const AxisLine& axis, const JobPlan& plan,
                           double radius) {
    FollowedPaths out;
    std::vector<bool> taken(pulses.size(), false);
    for (const double face_deg : plan.faces) {
        const auto is_free = [face_deg](const PlannedPath& path) {
            return path.kind == PathKind::free_path && std::abs(path.face_deg - face_deg) < 1e-6;
        };
        if (std::ranges::any_of(plan.paths, is_free)) {
            Follower follower(plan, face_deg, radius);
            follower.follow(shots_on(face_deg, pulses, axis), taken);
            follower.report(out.paths);
        }
    }
    for (std::size_t i = 0; i < pulses.size(); ++i) {
        if (!taken[i]) {
            out.others.push_back(pulses[i]);
        }
    }
    return out;
}

}  // namespace sc::host
