// SPDX-License-Identifier: Apache-2.0
#include "host/verification/path_deviation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "host/formats/error.hpp"

namespace sc::host {

namespace {

constexpr std::size_t kMostCells = 10'000'000;
/// Places are kept to 1000 m, as a motion trace is.
constexpr double kFarthest = 1e3;
/// Half a picometre in each direction, of a sample and of a point of the path.
constexpr double kRoundingPm = 2.0;
constexpr double kLoosening = 1.5;
constexpr int kLoosenings = 10;
/// Halvings of the bracket around the least radius: the deviation is then right to a thousandth of it.
constexpr int kHalvings = 10;

/// A place on the path: segment, and part of it from 0 to 1.
struct Place {
    std::size_t segment = 0;
    double part = 0.0;
};
/// The parts of one segment that a sample may be at; empty if from > to.
struct Cell {
    double from = 1.0;
    double to = 0.0;
    [[nodiscard]] bool empty() const noexcept { return from > to; }
};
constexpr Cell kNowhere{};

/// Two neighbouring samples that differ, picometres.
struct Chord {
    Vec3 from;
    Vec3 to;
    double bulge = 0.0;  ///< how far the motion may leave the chord between the two
};

double to_chord(const Vec3& point, const Chord& chord) noexcept {
    const Vec3 way = chord.to - chord.from;
    const Vec3 off = point - chord.from;
    const double square = dot(way, way);
    const double part = square > 0.0 ? std::clamp(dot(off, way) / square, 0.0, 1.0) : 0.0;
    return norm(off - part * way);
}

/// The polyline in picometres: whole numbers, exact in double up to 9 km.
class Polyline {
public:
    explicit Polyline(std::span<const Vec3> path) {
        if (path.size() < 2) {
            throw InputError({.problem = "the path has too few points",
                              .value = std::to_string(path.size()),
                              .action = "give at least two"});
        }
        for (const Vec3& p : path) {
            for (std::size_t i = 0; i < 3; ++i) {
                if (!(std::abs(p[i]) <= kFarthest)) {
                    throw InputError({.problem = "point " + std::to_string(points_.size()) + " of the path is no place",
                                      .value = std::to_string(p[i]),
                                      .action = "give finite coordinates within 1000 m"});
                }
            }
            points_.push_back({std::nearbyint(p.x * kPmPerMetre), std::nearbyint(p.y * kPmPerMetre),
                               std::nearbyint(p.z * kPmPerMetre)});
        }
    }
    [[nodiscard]] std::size_t segments() const noexcept { return points_.size() - 1; }
    [[nodiscard]] const Vec3& vertex(std::size_t i) const noexcept { return points_[i]; }
    /// Nearest part of the whole line through a segment; 0 for a segment without length.
    [[nodiscard]] double foot(const Vec3& place, std::size_t segment) const noexcept {
        const Vec3 way = points_[segment + 1] - points_[segment];
        const double square = dot(way, way);
        return square > 0.0 ? dot(place - points_[segment], way) / square : 0.0;
    }
    [[nodiscard]] double distance(const Vec3& place, const Place& on) const noexcept {
        const Vec3 way = points_[on.segment + 1] - points_[on.segment];
        return norm(place - points_[on.segment] - on.part * way);
    }
    /// The parts of a segment within `radius` of a place.
    [[nodiscard]] Cell within(const Vec3& place, std::size_t segment, double radius) const noexcept {
        const double middle = foot(place, segment);
        const double off = distance(place, {segment, middle});
        if (off > radius) {
            return kNowhere;
        }
        const double length = norm(points_[segment + 1] - points_[segment]);
        if (!(length > 0.0)) {
            return {0.0, 1.0};
        }
        const double reach = std::sqrt((radius - off) * (radius + off)) / length;
        return {std::max(0.0, middle - reach), std::min(1.0, middle + reach)};
    }

private:
    std::vector<Vec3> points_;
};

Vec3 vec_of(const AxisPositions& p) noexcept {
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

/// The samples that move, each with its index in the trace. First and last stand twice: motion may begin and end by
/// passing points of the path that all lie within the tolerance of where it stands.
class Track {
public:
    explicit Track(std::span<const AxisPositions> samples) : samples_(samples) {
        for (std::size_t i = 0; i < samples.size(); ++i) {
            if (i == 0 || vec_of(samples[i]) != places_.back()) {
                places_.push_back(vec_of(samples[i]));
                index_.push_back(i);
            }
            if (i == 0 || i + 1 == samples.size()) {
                places_.push_back(places_.back());
                index_.push_back(i);
            }
        }
    }
    [[nodiscard]] std::size_t size() const noexcept { return places_.size(); }
    [[nodiscard]] const Vec3& place(std::size_t i) const noexcept { return places_[i]; }
    [[nodiscard]] std::size_t index(std::size_t i) const noexcept { return index_[i]; }
    [[nodiscard]] Chord chord(std::size_t i) const noexcept { return {places_[i], places_[i + 1], bulge(i)}; }

private:
    [[nodiscard]] Vec3 sample(std::size_t i, int offset) const noexcept {
        const auto last = static_cast<std::ptrdiff_t>(samples_.size()) - 1;
        const auto at = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(i) + offset, 0, last);
        return vec_of(samples_[static_cast<std::size_t>(at)]);
    }
    /// Between two samples a motion of acceleration a leaves their chord by up to a T²/8. The largest a there is at
    /// most the larger second difference at the two ends and a third difference, which jerk can hide in their averages.
    [[nodiscard]] double bulge(std::size_t i) const noexcept {
        if (places_[i] == places_[i + 1]) {
            return 0.0;
        }
        const std::size_t n = index_[i + 1];  // the chord is from sample n − 1 to n
        const Vec3 before = sample(n, 0) - 2.0 * sample(n, -1) + sample(n, -2);
        const Vec3 after = sample(n, 1) - 2.0 * sample(n, 0) + sample(n, -1);
        return (std::max(norm(before), norm(after)) + norm(after - before)) / 8.0;
    }

    std::span<const AxisPositions> samples_;
    std::vector<Vec3> places_;
    std::vector<std::size_t> index_;
};

/// For each sample the places at which it can be when all before it are matched.
class Matching {
public:
    /// `radius` and `cover` in pm.
    Matching(const Polyline& path, const Track& track, double radius, double cover, bool may_return)
        : path_(&path), track_(&track), radius_(radius), cover_(cover), may_return_(may_return) {
        rows_.push_back({0, 0, 1});
        cells_.push_back({0.0, 0.0});
        while (rows_.size() < track.size() && rows_.back().count > 0) {
            if (may_return_) {
                advance_both_ways();
            } else {
                advance();
            }
            if (cells_.size() > kMostCells) {
                overfull_ = true;
                return;
            }
        }
    }
    /// Given up: too many places to keep.
    [[nodiscard]] bool overfull() const noexcept { return overfull_; }
    [[nodiscard]] bool complete() const noexcept {
        const Row& row = rows_.back();
        return !overfull_ && rows_.size() == track_->size() && row.count > 0 &&
               row.segment + row.count == path_->segments() && cells_.back().to >= 1.0;
    }
    /// Rows that have a place.
    [[nodiscard]] std::size_t alive() const noexcept { return rows_.size() - (rows_.back().count == 0 ? 1 : 0); }
    /// The furthest place of the last row that has one.
    [[nodiscard]] Place furthest() const noexcept {
        const Row& row = rows_[alive() - 1];
        return {row.segment + row.count - 1, cells_[row.first + row.count - 1].to};
    }

    /// In the same segment, the place nearest to its sample.
    [[nodiscard]] Place nearest_at_end() const noexcept {
        const Place end = furthest();
        const Row& row = rows_[alive() - 1];
        const double foot = path_->foot(track_->place(alive() - 1), end.segment);
        return {end.segment, std::clamp(foot, cells_[row.first + row.count - 1].from, end.part)};
    }

    /// Distance of a sample from the nearest of all places that it can be at: no matching of this radius, or of a
    /// smaller one, has it nearer.
    [[nodiscard]] double least(std::size_t i) const noexcept {
        const Row& row = rows_[i];
        double best = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k < row.count; ++k) {
            const Cell& cell = cells_[row.first + k];
            if (!cell.empty()) {
                const double foot = path_->foot(track_->place(i), row.segment + k);
                const Place at{row.segment + k, std::clamp(foot, cell.from, cell.to)};
                best = std::min(best, path_->distance(track_->place(i), at));
            }
        }
        return best;
    }

    struct Step {
        Place place;
        double distance = 0.0;
    };
    /// The nearest place of row i from which the chord to `next`, a place of row i + 1, passes no vertex too far off.
    [[nodiscard]] Step before(std::size_t i, const Place& next) const {
        const Row& row = rows_[i];
        const Chord chord = track_->chord(i);
        Step best{next, std::numeric_limits<double>::infinity()};
        const auto consider = [&](std::size_t segment) {
            if (segment < row.segment || segment >= row.segment + row.count) {
                return;
            }
            Cell cell = cells_[row.first + segment - row.segment];
            if (segment == next.segment && !may_return_) {
                cell.to = std::min(cell.to, next.part);
            }
            if (!cell.empty()) {
                const Place at{segment, std::clamp(path_->foot(track_->place(i), segment), cell.from, cell.to)};
                const double distance = path_->distance(track_->place(i), at);
                best = distance < best.distance ? Step{at, distance} : best;
            }
        };
        consider(next.segment);
        for (std::size_t segment = next.segment; segment > row.segment && passes(segment, chord); --segment) {
            consider(segment - 1);
        }
        for (std::size_t segment = next.segment + 1;
             may_return_ && segment < row.segment + row.count && passes(segment, chord); ++segment) {
            consider(segment);
        }
        return best;
    }

private:
    struct Row {
        std::size_t segment = 0;  ///< of the first cell
        std::size_t first = 0;    ///< its index
        std::size_t count = 0;    ///< 0: nowhere
    };

    [[nodiscard]] bool passes(std::size_t vertex, const Chord& chord) const noexcept {
        return to_chord(path_->vertex(vertex), chord) - chord.bulge <= cover_;
    }

    void advance() {
        const Row old = rows_.back();
        const Chord chord = track_->chord(rows_.size() - 1);
        Row row{old.segment, cells_.size(), 0};
        std::size_t used = 0;  // cells up to the last that is not empty
        bool carried = false;  // the segment's start can be reached from the one before, as far as that one goes
        for (std::size_t segment = old.segment; segment < path_->segments(); ++segment) {
            const bool enters = carried && passes(segment, chord);
            const bool is_old = segment < old.segment + old.count;
            const Cell was = is_old ? cells_[old.first + segment - old.segment] : kNowhere;
            if (!is_old && !enters) {
                break;
            }
            carried = enters || !was.empty();
            Cell cell = kNowhere;
            if (carried) {
                cell = path_->within(chord.to, segment, radius_);
                cell.from = std::max(cell.from, enters ? 0.0 : was.from);
            }
            if (cell.empty() && cells_.size() == row.first) {
                row.segment = segment + 1;
                continue;
            }
            cells_.push_back(cell);
            used = cell.empty() ? used : cells_.size() - row.first;
        }
        cells_.resize(row.first + used);
        row.count = used;
        rows_.push_back(row);
    }

    void advance_both_ways() {
        const Row old = rows_.back();
        const Chord chord = track_->chord(rows_.size() - 1);
        // First and last cell of a row are never empty; from there on as far as the vertices let it.
        std::size_t low = old.segment;
        while (low > 0 && passes(low, chord)) {
            --low;
        }
        std::size_t high = old.segment + old.count - 1;
        while (high + 1 < path_->segments() && passes(high + 1, chord)) {
            ++high;
        }
        std::vector<bool> reached(high - low + 1, true);
        for (std::size_t k = 0; k < old.count; ++k) {
            const std::size_t segment = old.segment + k;
            reached[segment - low] = !cells_[old.first + k].empty() ||
                                     (segment > low && reached[segment - low - 1] && passes(segment, chord));
        }
        for (std::size_t segment = old.segment + old.count - 1; segment-- > old.segment;) {
            reached[segment - low] =
                reached[segment - low] || (reached[segment + 1 - low] && passes(segment + 1, chord));
        }
        Row row{low, cells_.size(), 0};
        std::size_t used = 0;
        for (std::size_t segment = low; segment <= high; ++segment) {
            const Cell cell = reached[segment - low] ? path_->within(chord.to, segment, radius_) : kNowhere;
            if (cell.empty() && cells_.size() == row.first) {
                row.segment = segment + 1;
                continue;
            }
            cells_.push_back(cell);
            used = cell.empty() ? used : cells_.size() - row.first;
        }
        cells_.resize(row.first + used);
        row.count = used;
        rows_.push_back(row);
    }

    const Polyline* path_;
    const Track* track_;
    double radius_;
    double cover_;
    bool may_return_;
    bool overfull_ = false;
    std::vector<Row> rows_;
    std::vector<Cell> cells_;
};

/// Walks the matching back from its end and notes the largest distances.
void measure(const Matching& matching, const Polyline& path, const Track& track, PathDeviation& out) {
    const std::size_t last = matching.alive() - 1;
    Place next = matching.furthest();
    if (!out.matched) {
        next = matching.nearest_at_end();
    }
    double largest = -1.0;
    double missed = -1.0;
    const auto note = [&](std::size_t row, double distance) {
        float& entry = out.of_sample[track.index(row)];
        entry = std::isnan(entry) ? static_cast<float>(distance) : std::max(entry, static_cast<float>(distance));
        if (distance > largest) {
            largest = distance;
            out.sample = track.index(row);
        }
    };
    const auto note_vertex = [&](std::size_t vertex, std::size_t row, double distance) {
        if (distance > missed) {
            missed = distance;
            out.vertex = vertex;
            out.miss_sample = track.index(row);
        }
    };
    note(last, path.distance(track.place(last), next));
    for (std::size_t i = last; i-- > 0;) {
        const Matching::Step step = matching.before(i, next);
        note(i, step.distance);
        const Chord chord = track.chord(i);
        const auto [first, end] = std::minmax(step.place.segment, next.segment);
        for (std::size_t vertex = first + 1; vertex <= end; ++vertex) {
            note_vertex(vertex, i + 1, std::max(0.0, to_chord(path.vertex(vertex), chord) - chord.bulge));
        }
        next = step.place;
    }
    out.deviation = std::max(0.0, largest) / kPmPerMetre;
    out.vertex_miss = std::max(0.0, missed) / kPmPerMetre;
}

/// The matching with the smallest radius. Choosing the nearest place for each sample from the end is the best for a
/// motion that never goes back; where samples jitter along the path it is not, and the radius is looked for.
Matching tightened(Matching matching, const Polyline& path, const Track& track, double cover, bool may_return) {
    double most = 0.0;
    Place next = matching.furthest();
    double least = matching.least(track.size() - 1);
    for (std::size_t i = track.size() - 1; i-- > 0;) {
        const Matching::Step step = matching.before(i, next);
        next = step.place;
        most = std::max(most, step.distance);
        least = std::max(least, matching.least(i));
    }
    most = std::max(most, path.distance(track.place(track.size() - 1), matching.furthest()));
    for (int i = 0; i < kHalvings && most - least > kRoundingPm + 1e-3 * least; ++i) {
        const double middle = 0.5 * (most + least);
        Matching tighter(path, track, middle, cover, may_return);
        if (tighter.complete()) {
            most = middle;
            matching = std::move(tighter);
        } else {
            least = middle;
        }
    }
    return matching;
}

void measure_loss(const Matching& matching, const Polyline& path, const Track& track, PathDeviation& out) {
    const Place furthest = matching.furthest();
    const std::size_t row = std::min(matching.alive(), track.size() - 1);
    out.lost_sample = track.index(row);
    out.lost_vertex = furthest.segment;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t segment = furthest.segment; segment < path.segments(); ++segment) {
        const double least = segment == furthest.segment ? furthest.part : 0.0;
        const double part = std::clamp(path.foot(track.place(row), segment), least, 1.0);
        nearest = std::min(nearest, path.distance(track.place(row), {segment, part}));
    }
    out.lost_distance = nearest / kPmPerMetre;
}

/// Samples that stand have the deviation of the one that came to stand; metres.
void spread(std::vector<float>& of_sample, std::size_t end) {
    for (std::size_t i = 0; i < end; ++i) {
        if (!std::isnan(of_sample[i])) {
            of_sample[i] /= static_cast<float>(kPmPerMetre);
        } else if (i > 0) {
            of_sample[i] = of_sample[i - 1];
        }
    }
}

}  // namespace

PathDeviation path_deviation(std::span<const AxisPositions> samples, std::span<const Vec3> path,
                             const PathTolerance& tolerance) {
    const Polyline line(path);
    PathDeviation out;
    out.of_sample.assign(samples.size(), std::numeric_limits<float>::quiet_NaN());
    if (samples.empty()) {
        return out;
    }
    const Track track(samples);
    out.start_gap = norm(track.place(0) - line.vertex(0)) / kPmPerMetre;
    out.end_gap = norm(track.place(track.size() - 1) - line.vertex(line.segments())) / kPmPerMetre;
    double radius = tolerance.tolerance * kPmPerMetre + kRoundingPm;
    double cover = tolerance.cover * kPmPerMetre + kRoundingPm;
    const bool starts = out.start_gap * kPmPerMetre <= radius;
    Matching matching(line, track, radius, cover, tolerance.may_return);
    if (matching.overfull()) {
        throw InputError({.problem = "the path is too dense for its tolerance, matching takes too much memory",
                          .value = std::to_string(path.size()) + " points",
                          .action = "thin the path out, or give a smaller tolerance"});
    }
    out.followed = matching.complete() && starts;
    for (int i = 0; i < kLoosenings && !matching.complete(); ++i) {
        radius *= kLoosening;
        cover *= kLoosening;
        Matching looser(line, track, radius, cover, tolerance.may_return);
        if (looser.overfull()) {
            break;
        }
        matching = std::move(looser);
    }
    out.matched = matching.complete();
    if (out.matched) {
        measure(tightened(std::move(matching), line, track, cover, tolerance.may_return), line, track, out);
    } else {
        measure(matching, line, track, out);
        measure_loss(matching, line, track, out);
    }
    spread(out.of_sample, out.matched ? samples.size() : out.lost_sample);
    return out;
}

}  // namespace sc::host
