// SPDX-License-Identifier: Apache-2.0
#include "host/path/look_plan.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "host/formats/error.hpp"
#include "host/path/check.hpp"
#include "host/path/curve.hpp"
#include "host/path/profile.hpp"
#include "shared/machine/sensors.hpp"
#include "shared/path/job_hash.hpp"

namespace sc::host {
namespace {

using Polyline = std::vector<Vec3>;

constexpr double kSampling = 0.5e-3;              ///< m between samples of a line
constexpr double kChord = 0.2e-3;                 ///< m: looks keep so near to the line
constexpr double kCovered = 0.5 * kSurfaceReach;  ///< m: a line so near to what was looked at has been
constexpr double kSameDepth = 0.1e-3;             ///< m: and so near in depth
constexpr double kLookSeconds = 0.15;             ///< to stand at an end of a look
constexpr std::size_t kSpareBins = 2;             ///< of a stretch, for its ends

Vec3 place_of(const PathPoint& p) {
    return {p.x / kWireUnitsPerMetre, p.y / kWireUnitsPerMetre, p.z / kWireUnitsPerMetre};
}
PathPoint wire_point(const Vec3& v) {
    const auto wire = [](double metres) {
        return static_cast<std::int32_t>(std::llround(metres * kWireUnitsPerMetre));
    };
    return {wire(v.x), wire(v.y), wire(v.z)};
}

/// The marked stretches of one path's items, sampled.
class Stretches {
public:
    void take(const Item& item) {
        if (const auto* point = std::get_if<PathPoint>(&item)) {
            go({.from = at_, .to = place_of(*point), .circle = std::nullopt});
        } else if (const auto* arc = std::get_if<PathArc>(&item)) {
            const Vec3 to = place_of(arc->to);
            go({.from = at_, .to = to, .circle = circle_through(at_, place_of(arc->via), to)});
        } else if (const auto* light = std::get_if<PathLight>(&item)) {
            lit_ = light->on;
            if (lit_) {
                stretches.push_back({at_});
            }
        }
    }
    std::vector<Polyline> stretches;

private:
    void go(const Piece& piece) {
        if (!begun_) {
            begun_ = true;
            stretches.push_back({piece.to});
        } else if (lit_) {
            const auto count = std::max(1, static_cast<int>(std::ceil(piece.length() / kSampling)));
            for (int i = 1; i <= count; ++i) {
                stretches.back().push_back(piece.at(static_cast<double>(i) / count));
            }
        }
        at_ = piece.to;
    }
    Vec3 at_;
    bool begun_ = false;
    bool lit_ = true;
};

double length(std::span<const Vec3> line) {
    double sum = 0.0;
    for (std::size_t i = 1; i < line.size(); ++i) {
        sum += norm(line[i] - line[i - 1]);
    }
    return sum;
}

double off_chord(const Vec3& place, const Vec3& from, const Vec3& to) {
    const Vec3 way = to - from;
    const double square = dot(way, way);
    const double share = square > 0.0 ? std::clamp(dot(place - from, way) / square, 0.0, 1.0) : 0.0;
    return norm(place - (from + share * way));
}

/// Ends of chords within kChord of the line (Douglas and Peucker), from `first` on without it, `last` included.
void chords(std::span<const Vec3> line, std::size_t first, std::size_t last, Polyline& out) {
    double worst = kChord;
    std::size_t split = 0;
    for (std::size_t i = first + 1; i < last; ++i) {
        const double off = off_chord(line[i], line[first], line[last]);
        if (off > worst) {
            worst = off;
            split = i;
        }
    }
    if (split == 0) {
        out.push_back(line[last]);
        return;
    }
    chords(line, first, split, out);
    chords(line, split, last, out);
}

std::size_t bins(const Polyline& stretch) {
    return static_cast<std::size_t>(std::ceil(length(stretch) / kSurfaceBin)) + kSpareBins;
}

class LookPlanner {
public:
    LookPlanner(JobPlan& plan, const SensorRay& sensor, double speed, const MachineConfig& machine,
                const Compensation& compensation)
        : plan_(plan), sensor_(sensor), speed_(speed), machine_(machine), compensation_(compensation) {}

    void run() {
        new_index_.resize(plan_.items.size() + 1);
        for (std::size_t i = 0; i < plan_.items.size();) {
            if (!std::holds_alternative<PathBegin>(plan_.items[i])) {
                flush();
                copy(i, i + 1);
                ++i;
                continue;
            }
            std::size_t end = i;
            Stretches found;
            while (!std::holds_alternative<PathEnd>(plan_.items[end])) {
                found.take(plan_.items[end++]);
            }
            take_path(i, end + 1, found.stretches);
            i = end + 1;
        }
        flush();
        new_index_.back() = items_.size();
        for (PlannedPath& path : plan_.paths) {
            const std::size_t end = path.first_item + path.item_count;
            const std::size_t last = new_index_[end - 1];
            path.first_item = new_index_[path.first_item];
            path.item_count = last + 1 - path.first_item;
        }
        plan_.items = std::move(items_);
        plan_.hash = job_hash(plan_.items);
    }

private:
    struct Range {
        std::size_t begin = 0;
        std::size_t end = 0;
    };
    struct Wanted {
        Polyline line;
        std::size_t path = 0;  ///< of plan_.paths
    };

    [[nodiscard]] std::size_t path_of(std::size_t item) const {
        const auto has = [item](const PlannedPath& p) {
            return item >= p.first_item && item < p.first_item + p.item_count;
        };
        return static_cast<std::size_t>(std::ranges::find_if(plan_.paths, has) - plan_.paths.begin());
    }

    [[nodiscard]] bool covered(const Polyline& stretch) const {
        return std::ranges::all_of(stretch, [this](const Vec3& p) {
            return std::ranges::any_of(seen_, [&p](const Vec3& s) {
                return std::hypot(p.x - s.x, p.z - s.z) <= kCovered && std::abs(p.y - s.y) <= kSameDepth;
            });
        });
    }

    /// Adds what the group has not seen of these to `out`; how many places it takes.
    std::size_t unseen(const std::vector<Polyline>& stretches, std::vector<const Polyline*>& out) {
        std::size_t sum = 0;
        for (const Polyline& stretch : stretches) {
            if (stretch.size() > 1 && !covered(stretch)) {
                out.push_back(&stretch);
                sum += bins(stretch);
                seen_.insert(seen_.end(), stretch.begin(), stretch.end());
            }
        }
        return sum;
    }

    void take_path(std::size_t begin, std::size_t end, const std::vector<Polyline>& stretches) {
        const std::size_t seen_before = seen_.size();
        std::vector<const Polyline*> wanted;
        std::size_t places = unseen(stretches, wanted);
        if (places_ + places > kSurfacePlaces && places_ > 0) {
            seen_.resize(seen_before);
            flush();
            wanted.clear();
            places = unseen(stretches, wanted);
        }
        const std::size_t path = path_of(begin);
        if (places > kSurfacePlaces) {
            refuse_length(plan_.paths[path], places);
        }
        places_ += places;
        for (const Polyline* stretch : wanted) {
            wanted_.push_back({*stretch, path});
        }
        ranges_.push_back({begin, end});
    }

    [[noreturn]] static void refuse_length(const PlannedPath& path, std::size_t places) {
        throw InputError(
            {.file = path.source.file.string(),
             .line = path.source.line,
             .problem = path.name.empty()
                            ? std::string("this line is too long for the Y sensor to look at before it is burnt")
                            : "path \"" + path.name +
                                  "\" is too long for the Y sensor to look at before it "
                                  "is burnt",
             .value = fmt::format("{} mm", places),
             .action = fmt::format("make several paths of it, each of {} mm or less, or take [surface] out of the job",
                                   kSurfacePlaces - kSpareBins)});
    }

    void copy(std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            new_index_[i] = items_.size();
            items_.push_back(plan_.items[i]);
        }
    }

    /// The looks of a group, then its paths.
    void flush() {
        for (const Wanted& wanted : wanted_) {
            add(wanted);
        }
        for (const Range& range : ranges_) {
            copy(range.begin, range.end);
        }
        wanted_.clear();
        ranges_.clear();
        seen_.clear();
        places_ = 0;
    }

    void add(const Wanted& wanted) {
        Polyline ends{wanted.line.front()};
        chords(wanted.line, 0, wanted.line.size() - 1, ends);
        const PlannedPath& path = plan_.paths[wanted.path];
        Vec3 before;
        for (std::size_t i = 0; i < ends.size(); ++i) {
            const Vec3 at = ends[i] - sensor_.origin.v;
            check_look(path, i > 0 ? before : at, at, machine_, compensation_);
            const PathPoint wire = wire_point(at);
            if (i > 0 && wire == wire_point(before)) {
                continue;
            }
            plan_.looks.push_back({items_.size(), wanted.path});
            const std::uint32_t speed = i == 0 ? 0 : static_cast<std::uint32_t>(std::llround(1e6 * speed_));
            items_.emplace_back(Look{speed, wire.x, wire.y, wire.z});
            plan_.expected_seconds_estimate += kLookSeconds + (i > 0 ? norm(at - before) / speed_ : way(at));
            before = at;
            at_ = at;
        }
    }

    [[nodiscard]] double way(const Vec3& to) const {
        double longest = 0.0;
        for (std::size_t i = 0; i < 3 && !items_.empty(); ++i) {
            const AxisConfig& axis = machine_.axis.at(i);
            longest = std::max(longest, move_time(to[i] - at_[i], {axis.speed, axis.acceleration, axis.jerk}));
        }
        return longest;
    }

    JobPlan& plan_;
    const SensorRay& sensor_;
    double speed_;
    const MachineConfig& machine_;
    const Compensation& compensation_;
    std::vector<Item> items_;
    std::vector<std::size_t> new_index_;
    std::vector<Wanted> wanted_;
    std::vector<Range> ranges_;
    Polyline seen_;
    std::size_t places_ = 0;
    Vec3 at_;
};

}  // namespace

void add_looks(JobPlan& plan, const SensorRay& sensor, Speed speed, const MachineConfig& machine,
               const Compensation& compensation) {
    LookPlanner(plan, sensor, speed.si(), machine, compensation).run();
}

}  // namespace sc::host
