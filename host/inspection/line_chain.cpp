// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/line_chain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>

#include "host/inspection/neighbours.hpp"

namespace sc::host {

namespace {

constexpr std::uint32_t kNone = 0xffffffffU;
constexpr double kBehind = -0.1;      ///< cosine: a follower lies ahead, all but
constexpr double kCorner = 0.9;       ///< cosine between tangents: less is a corner
constexpr double kCornerReach = 6.0;  ///< spacings between the places beside a corner

constexpr double kTurned = 0.15;  ///< rad that a normal between two places may be off

struct Link {
    double cost = 0.0;
    std::uint32_t from = 0;
    std::uint32_t to = 0;
};

class Chainer {
public:
    Chainer(std::vector<LinePlace> places, const Plane& plane, const CutOptions& options, double spacing)
        : places_(std::move(places)), options_(&options), spacing_(spacing) {
        for (const LinePlace& place : places_) {
            const Vec3 t = cross(plane.normal, place.normal);
            tangents_.push_back((1.0 / norm(t)) * t);
            where_.push_back(place.place);
        }
    }

    void run(CutLine& out) {
        join();
        for (std::uint32_t i = 0; i < places_.size(); ++i) {
            if (before_[i] == kNone) {
                open_.push_back(string_from(i));
            }
        }
        for (std::uint32_t i = 0; i < places_.size(); ++i) {
            if (!done_[i]) {
                keep(string_from(i), true, out);
            }
        }
        drop_short(out);
        stitch(out);
        for (const auto& string : open_) {
            keep(string, false, out);
        }
        find_gaps(out);
        for (LineRun& run : out.runs) {
            thin(run);
            out.length += run.length;
        }
        std::ranges::sort(out.runs, [](const LineRun& a, const LineRun& b) {
            const Vec3& p = a.places.front().place;
            const Vec3& q = b.places.front().place;
            return a.length != b.length ? a.length > b.length : std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z);
        });
    }

private:
    /// The cheapest links first, one from and one to each place.
    void join() {
        const Neighbours neighbours(where_, options_->gap);
        std::vector<Link> links;
        std::array<std::uint32_t, 512> about{};
        for (std::uint32_t i = 0; i < places_.size(); ++i) {
            const std::size_t count = neighbours.about(i, about);
            for (std::size_t k = 0; k < count; ++k) {
                const Vec3 way = where_[about[k]] - where_[i];
                const double length = norm(way);
                const double here = dot(way, tangents_[i]) / length;
                const double there = dot(way, tangents_[about[k]]) / length;
                if (length > 0.0 && here > kBehind && there > kBehind) {
                    links.push_back({length * (5.0 - 2.0 * here - 2.0 * there), i, about[k]});
                }
            }
        }
        std::ranges::sort(links, [](const Link& a, const Link& b) {
            return a.cost != b.cost ? a.cost < b.cost : std::pair(a.from, a.to) < std::pair(b.from, b.to);
        });
        after_.assign(places_.size(), kNone);
        before_.assign(places_.size(), kNone);
        done_.assign(places_.size(), false);
        for (const Link& link : links) {
            if (after_[link.from] == kNone && before_[link.to] == kNone && after_[link.to] != link.from) {
                after_[link.from] = link.to;
                before_[link.to] = link.from;
            }
        }
    }

    std::vector<std::uint32_t> string_from(std::uint32_t first) {
        std::vector<std::uint32_t> out;
        for (std::uint32_t i = first; i != kNone && !done_[i]; i = after_[i]) {
            done_[i] = true;
            out.push_back(i);
        }
        return out;
    }

    void drop_short(CutLine& out) {
        out.short_pieces += std::erase_if(open_, [this](const std::vector<std::uint32_t>& string) {
            double length = 0.0;
            for (std::size_t k = 1; k < string.size(); ++k) {
                length += norm(where_[string[k]] - where_[string[k - 1]]);
            }
            return string.size() < 3 || length < options_->least_length;
        });
    }

    /// Joins ends that no place was left for: the nearest first. At edges the last places of a face may reach past the
    /// first ones of the next; those go.
    void stitch(CutLine& out) {
        while (true) {
            double least = options_->gap;
            std::size_t first = 0;
            std::size_t second = 0;
            for (std::size_t i = 0; i < open_.size(); ++i) {
                for (std::size_t j = 0; j < open_.size(); ++j) {
                    const double length = norm(where_[open_[j].front()] - where_[open_[i].back()]);
                    if (length < least && fits(open_[i], open_[j], i == j)) {
                        least = length;
                        first = i;
                        second = j;
                    }
                }
            }
            if (least >= options_->gap) {
                return;
            }
            trim(open_[first], open_[second]);
            if (first == second) {
                keep(open_[first], true, out);
            } else {
                open_[first].insert(open_[first].end(), open_[second].begin(), open_[second].end());
            }
            open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(second));
        }
    }

    /// Whether one end may go on into another beginning: not backwards, but for a few places.
    [[nodiscard]] bool fits(const std::vector<std::uint32_t>& from, const std::vector<std::uint32_t>& to,
                            bool same) const {
        const Vec3 way = where_[to.front()] - where_[from.back()];
        const double near = kCornerReach * spacing_;
        const bool enough = from.size() >= (same ? 12U : 6U) && to.size() >= 6;
        return enough && (norm(way) < near || (dot(way, tangents_[from.back()]) > kBehind * norm(way) &&
                                               dot(way, tangents_[to.front()]) > kBehind * norm(way)));
    }

    void trim(std::vector<std::uint32_t>& from, std::vector<std::uint32_t>& to) const {
        for (int k = 0; k < 2; ++k) {
            const Vec3 way = where_[to.front()] - where_[from.back()];
            if (dot(way, tangents_[from.back()]) < 0.0) {
                from.pop_back();
            } else if (dot(way, tangents_[to.front()]) < 0.0) {
                to.erase(to.begin());
            }
        }
    }

    void keep(const std::vector<std::uint32_t>& string, bool closed, CutLine& out) const {
        LineRun run;
        run.closed = closed;
        for (std::size_t k = 0; k < string.size(); ++k) {
            const std::uint32_t i = string[k];
            run.places.push_back(places_[i]);
            if (k + 1 < string.size() || closed) {
                const std::uint32_t j = string[(k + 1) % string.size()];
                run.length += norm(where_[j] - where_[i]);
                if (const auto place = corner(i, j)) {
                    run.places.push_back(*place);
                }
            }
        }
        if (run.length < options_->least_length || run.places.size() < 3) {
            ++out.short_pieces;
            return;
        }
        out.runs.push_back(std::move(run));
    }

    /// Where the tangents of two places on different faces meet.
    [[nodiscard]] std::optional<LinePlace> corner(std::uint32_t i, std::uint32_t j) const {
        const Vec3 way = where_[j] - where_[i];
        const double cosine = dot(tangents_[i], tangents_[j]);
        if (cosine > kCorner || cosine < -kCorner || norm(way) > kCornerReach * spacing_) {
            return std::nullopt;
        }
        const double a = dot(way, tangents_[i]);
        const double b = dot(way, tangents_[j]);
        const double ahead = (a - cosine * b) / (1.0 - cosine * cosine);
        const double behind = (b - cosine * a) / (1.0 - cosine * cosine);
        if (ahead <= 0.0 || behind <= 0.0 || std::max(ahead, behind) > norm(way)) {
            return std::nullopt;
        }
        const Vec3 normal = places_[i].normal + places_[j].normal;
        return LinePlace{where_[i] + ahead * tangents_[i], (1.0 / norm(normal)) * normal,
                         std::max(places_[i].sigma, places_[j].sigma)};
    }

    /// From the end of each open run to the nearest beginning.
    static void find_gaps(CutLine& out) {
        for (const LineRun& run : out.runs) {
            if (run.closed) {
                continue;
            }
            const Vec3 end = run.places.back().place;
            std::optional<LineGap> nearest;
            for (const LineRun& other : out.runs) {
                const Vec3 begin = other.places.front().place;
                const double length = norm(begin - end);
                if (!other.closed && (!nearest || length < nearest->length)) {
                    nearest = LineGap{end, begin, length};
                }
            }
            out.gaps.push_back(*nearest);
        }
        std::ranges::sort(out.gaps, [](const LineGap& a, const LineGap& b) { return a.length > b.length; });
    }

    /// Leaves out what lies within the chord error of the straight way.
    void thin(LineRun& run) const {
        auto& places = run.places;
        if (run.closed) {
            places.push_back(places.front());
        }
        std::vector<bool> kept(places.size(), false);
        kept.front() = kept.back() = true;
        std::vector<std::pair<std::size_t, std::size_t>> stretches;
        if (run.closed) {
            kept[places.size() / 2] = true;
            stretches = {{0, places.size() / 2}, {places.size() / 2, places.size() - 1}};
        } else {
            stretches = {{0, places.size() - 1}};
        }
        while (!stretches.empty()) {
            const auto [first, last] = stretches.back();
            stretches.pop_back();
            const auto [worst, off] = farthest(places, first, last);
            if (off > options_->chord) {
                kept[worst] = true;
                stretches.push_back({first, worst});
                stretches.push_back({worst, last});
            }
        }
        std::vector<LinePlace> left;
        for (std::size_t i = 0; i + (run.closed ? 1 : 0) < places.size(); ++i) {
            if (kept[i]) {
                left.push_back(places[i]);
            }
        }
        places = std::move(left);
        run.length = run.closed ? norm(places.front().place - places.back().place) : 0.0;
        for (std::size_t i = 1; i < places.size(); ++i) {
            run.length += norm(places[i].place - places[i - 1].place);
        }
    }

    [[nodiscard]] std::pair<std::size_t, double> farthest(const std::vector<LinePlace>& places, std::size_t first,
                                                          std::size_t last) const {
        std::pair<std::size_t, double> out{first, 0.0};
        const Vec3 a = places[first].place;
        const Vec3 ab = places[last].place - a;
        const double squared = dot(ab, ab);
        for (std::size_t i = first + 1; i < last; ++i) {
            const Vec3 ap = places[i].place - a;
            const double share = squared > 0.0 ? std::clamp(dot(ap, ab) / squared, 0.0, 1.0) : 0.0;
            // The normal must stay right as well: who goes along the line asks for it between the places.
            const Vec3 between = (1.0 - share) * places[first].normal + share * places[last].normal;
            const double turned = norm(places[i].normal - between);
            const double off = std::max(norm(ap - share * ab), options_->chord / kTurned * turned);
            if (off > out.second) {
                out = {i, off};
            }
        }
        return out;
    }

    std::vector<LinePlace> places_;
    const CutOptions* options_;
    double spacing_;
    std::vector<Vec3> where_;
    std::vector<Vec3> tangents_;
    std::vector<std::uint32_t> after_;
    std::vector<std::uint32_t> before_;
    std::vector<bool> done_;
    std::vector<std::vector<std::uint32_t>> open_;  ///< strings with two ends
};

}  // namespace

void chain(std::vector<LinePlace> places, const Plane& plane, const CutOptions& options, double spacing, CutLine& out) {
    Chainer(std::move(places), plane, options, spacing).run(out);
}

}  // namespace sc::host
