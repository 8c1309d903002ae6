// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/borrowing.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "host/formats/error.hpp"
#include "host/inspection/active_set.hpp"
#include "host/inspection/parallel.hpp"

namespace sc::host {

namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kMm = 1e3;
constexpr double kKept = 1e-9;  ///< mm of the smallest margin that the later goals may take: room to breathe for them
constexpr int kRounds = 20;
constexpr int kRough = 5;              ///< rounds that may leave rows out that count
constexpr std::size_t kFirst = 20000;  ///< rows of the first round, and as many from everywhere
constexpr double kStill = 1e-8;        ///< mm of motion at the part's rim

constexpr std::uint32_t kNoStrip = 0xffffffffU;

/// One condition, linear about the present place: value + its row · x ≥ 0, in mm.
struct Condition {
    std::uint32_t point = 0;
    std::uint32_t strip = kNoStrip;  ///< a kept strip instead of what is nearest now
    bool upper = false;
    bool of_strip = false;  ///< the reading was over a flat strip of a bore
    double value = 0.0;
    Vec3 place;      ///< of the point, now
    Vec3 direction;  ///< in which its height grows
};

/// A strip of a bore that once stopped a point: it goes on to count as a plane.
struct Strip {
    std::uint32_t point = 0;
    Vec3 on;
    Vec3 normal;
};

/// What the variance over one face and its growth need.
struct Sums {
    double n = 0.0;
    double d = 0.0;
    double dd = 0.0;
    Vector6 g = Vector6::Zero();
    Vector6 dg = Vector6::Zero();
    Eigen::Matrix<double, 21, 1> gg = Eigen::Matrix<double, 21, 1>::Zero();  ///< upper triangle of Σ g gᵀ, by rows

    void add(double value, const Vector6& row) {
        n += 1.0;
        d += value;
        dd += value * value;
        g += row;
        dg += value * row;
        Eigen::Index at = 0;
        for (Eigen::Index i = 0; i < 6; ++i) {
            for (Eigen::Index k = i; k < 6; ++k) {
                gg[at++] += row[i] * row[k];
            }
        }
    }
    void add(const Sums& other) {
        n += other.n;
        d += other.d;
        dd += other.dd;
        g += other.g;
        dg += other.dg;
        gg += other.gg;
    }
    [[nodiscard]] Eigen::Matrix<double, 6, 6> whole() const {
        Eigen::Matrix<double, 6, 6> out;
        Eigen::Index at = 0;
        for (Eigen::Index i = 0; i < 6; ++i) {
            for (Eigen::Index k = i; k < 6; ++k) {
                out(i, k) = out(k, i) = gg[at++];
            }
        }
        return out;
    }
};

class Borrower {
public:
    Borrower(const DistanceField& field, const FaceGauge& gauge, std::span<const BorrowPoint> points,
             std::span<const BorrowGroup> groups, const BorrowOptions& options)
        : gauge_(&gauge),
          points_(points),
          groups_(groups),
          options_(&options),
          centre_(0.5 * (field.low() + field.high())),
          length_(0.5 * field.diagonal()) {
        find_basis();
        values_.resize(points.size());
    }

    Borrowing run() {
        Borrowing out;
        double last_margin = -std::numeric_limits<double>::infinity();
        double reach = std::numeric_limits<double>::infinity();  // how far the next step may go, mm
        for (out.rounds = 1;; ++out.rounds) {
            look();
            const double margin = margin_;
            if (out.rounds == 1) {
                out.margin_before = margin / kMm;
                out.variance_before = variance() / (kMm * kMm);
            }
            // Rows that are so far above the smallest that the step cannot bring them there are left out. On the first
            // rounds the step may be longer than that: what they miss is seen at the next look.
            const double limit = std::min(margin + 4.0 * reach, lowest(kFirst));
            build_conditions(limit, out.rounds <= kRough ? points_.size() / kFirst + 1 : 0);
            Eigen::VectorXd step = improve(out, margin);
            bool complete = 4.0 * step.norm() <= limit - margin;
            if (!complete && out.rounds > kRough) {
                build_conditions(std::numeric_limits<double>::infinity(), 0);
                step = improve(out, margin);
                complete = true;
            }
            const double size = step.norm();
            if ((size < kStill && complete) || out.rounds == kRounds ||
                (out.rounds > 6 && margin < last_margin + 1e-9 && size < 1e-5)) {
                out.margin = margin / kMm;
                break;
            }
            for (const Strip& strip : found_) {
                strips_.push_back(strip);
            }
            reach = std::max(size, 1e-3);
            last_margin = margin;
            total_ += basis_ * step;
        }
        out.variance = variance() / (kMm * kMm);
        out.motion = motion();
        for (std::size_t i = 0; i < 6; ++i) {
            const double v = total_[static_cast<Eigen::Index>(i)] / kMm;
            out.along[i] = i < 3 ? v : v / length_;
        }
        return out;
    }

private:
    /// Directions that may be moved in, orthonormal, as columns over (shift, turn · length).
    void find_basis() {
        std::vector<Vector6> fixed;
        for (Eigen::Index i = 0; i < 6; ++i) {
            if (!options_->free[static_cast<std::size_t>(i)]) {
                fixed.push_back(Vector6::Unit(i));
            }
        }
        for (const DatumPlane& datum : options_->locked) {
            const Vec3 n = datum.normal.v;
            const Vec3 arm = (1.0 / length_) * cross(datum.point.v - centre_, n);
            fixed.push_back((Vector6() << n.x, n.y, n.z, arm.x, arm.y, arm.z).finished());
            for (const Vec3& e : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
                const Vec3 c = cross(n, e);
                fixed.push_back((Vector6() << 0, 0, 0, c.x, c.y, c.z).finished());
            }
        }
        if (fixed.empty()) {
            basis_ = Eigen::MatrixXd::Identity(6, 6);
            return;
        }
        Eigen::MatrixXd rows(static_cast<Eigen::Index>(fixed.size()), 6);
        for (std::size_t i = 0; i < fixed.size(); ++i) {
            rows.row(static_cast<Eigen::Index>(i)) = fixed[i].transpose();
        }
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows, Eigen::ComputeFullV);
        Eigen::Index rank = 0;
        for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i) {
            rank += svd.singularValues()[i] > 1e-9 ? 1 : 0;
        }
        if (rank == 6) {
            throw InputError({.file = {},
                              .problem = "no motion is left free for borrowing",
                              .value = std::to_string(options_->locked.size()) + " locked datums",
                              .action = "free a motion, or lock fewer datums"});
        }
        basis_ = svd.matrixV().rightCols(6 - rank);
    }

    [[nodiscard]] Rigid<frame::W, frame::W> motion() const {
        const Mat3 turn = turn_by((1.0 / (length_ * kMm)) * Vec3{total_[3], total_[4], total_[5]});
        const Vec3 shift = (1.0 / kMm) * Vec3{total_[0], total_[1], total_[2]};
        return {turn, centre_ - turn * centre_ + shift};
    }

    [[nodiscard]] Vector6 row_of(const Vec3& place, const Vec3& direction) const {
        // The turn is a vector that is added to the total; the derivative is taken as if it were applied after it,
        // which is the same but for a relative error of the turn itself (1e-2 at most), gone at the fixed point.
        const Vec3 arm = (1.0 / length_) * cross(place - centre_ - shift_, direction);
        return (Vector6() << direction.x, direction.y, direction.z, arm.x, arm.y, arm.z).finished();
    }

    [[nodiscard]] Vec3 place_of(std::uint32_t point) const {
        return now_.rotation * points_[point].place + now_.translation;
    }

    /// Heights at the present place, the smallest margin, and what the variance needs. One set of sums a stretch, added
    /// up in order: the same whatever the threads.
    void look() {
        now_ = motion();
        shift_ = (1.0 / kMm) * Vec3{total_[0], total_[1], total_[2]};
        constexpr std::size_t kStretch = 65536;
        std::vector<std::vector<Sums>> pieces((points_.size() + kStretch - 1) / kStretch);
        std::vector<double> least(pieces.size(), std::numeric_limits<double>::infinity());
        parallel_pieces(points_.size(), kStretch, thread_count(options_->threads),
                        [&](std::size_t begin, std::size_t end, unsigned) {
                            auto& sums = pieces[begin / kStretch];
                            sums.resize(groups_.size());
                            least[begin / kStretch] = look_at(begin, end, sums);
                        });
        margin_ = *std::ranges::min_element(least);
        sums_.assign(groups_.size(), {});
        for (const auto& piece : pieces) {
            for (std::size_t i = 0; i < sums_.size(); ++i) {
                sums_[i].add(piece[i]);
            }
        }
    }

    double look_at(std::size_t begin, std::size_t end, std::vector<Sums>& sums) {
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t i = begin; i < end; ++i) {
            const BorrowGroup& group = groups_[points_[i].group];
            const Vec3 place = place_of(static_cast<std::uint32_t>(i));
            const Reading reading = gauge_->at(place, group.face);
            values_[i] = reading.value;
            least = std::min({least, kMm * (reading.value - group.least), kMm * (group.most - reading.value)});
            sums[points_[i].group].add(kMm * reading.value, row_of(place, reading.direction));
        }
        return least;
    }

    /// The so-manieth of the margins, mm.
    [[nodiscard]] double lowest(std::size_t count) const {
        if (points_.size() <= count) {
            return std::numeric_limits<double>::infinity();
        }
        std::vector<double> margins(points_.size());
        for (std::size_t i = 0; i < points_.size(); ++i) {
            const BorrowGroup& group = groups_[points_[i].group];
            margins[i] = kMm * std::min(values_[i] - group.least, group.most - values_[i]);
        }
        const auto at = margins.begin() + static_cast<std::ptrdiff_t>(count);
        std::nth_element(margins.begin(), at, margins.end());
        return *at;
    }

    /// Those whose value is at most `limit`, and every `stride`-th besides (0: none).
    void build_conditions(double limit, std::size_t stride) {
        conditions_.clear();
        for (std::uint32_t i = 0; i < points_.size(); ++i) {
            const BorrowGroup& group = groups_[points_[i].group];
            const bool always = stride > 0 && i % stride == 0;
            const double lower = kMm * (values_[i] - group.least);
            const double upper = kMm * (group.most - values_[i]);
            if (std::min(lower, upper) > limit && !always) {
                continue;
            }
            const Vec3 place = place_of(i);
            const Reading reading = gauge_->at(place, group.face);
            if (lower <= limit || always) {
                conditions_.push_back({i, kNoStrip, false, reading.strip, lower, place, reading.direction});
            }
            if (std::isfinite(upper) && (upper <= limit || always)) {
                conditions_.push_back({i, kNoStrip, true, reading.strip, upper, place, reading.direction});
            }
        }
        for (std::uint32_t i = 0; i < strips_.size(); ++i) {
            const Strip& strip = strips_[i];
            const Vec3 place = place_of(strip.point);
            const double height = dot(place - strip.on, strip.normal);
            const double value = kMm * (height - groups_[points_[strip.point].group].least);
            if (value <= limit) {
                conditions_.push_back({strip.point, i, false, false, value, place, strip.normal});
            }
        }
    }

    [[nodiscard]] Vector6 gradient_of(const Condition& c) const {
        const Vector6 gradient = row_of(c.place, c.direction);
        return c.upper ? Vector6(-gradient) : gradient;
    }

    /// Rows of the motion's own bounds, in the basis: they hold for the whole motion, not for the step.
    void add_bounds(HalfSpaces& rows, Eigen::Index at) const {
        for (Eigen::Index i = 0; i < 6; ++i) {
            const auto k = static_cast<std::size_t>(i);
            const double bound = kMm * options_->bound[k] * (k < 3 ? 1.0 : length_);
            for (const double side : {-1.0, 1.0}) {
                rows.a.row(at).head(basis_.cols()) = -side * basis_.row(i);
                rows.b[at] = side * total_[i] - bound;
                ++at;
            }
        }
    }

    /// The three goals, one after the other, about the present place. The first one's proof goes into `out`.
    Eigen::VectorXd improve(Borrowing& out, double margin) {
        const Eigen::Index k = basis_.cols();
        const auto m = static_cast<Eigen::Index>(conditions_.size());
        HalfSpaces rows;
        rows.a.resize(m + 12, k + 1);
        rows.a.bottomRows(12).setZero();
        rows.b.setZero(m + 12);
        rows.unknowns = k + 1;
        parallel_pieces(conditions_.size(), 8192, thread_count(options_->threads),
                        [&](std::size_t begin, std::size_t end, unsigned) {
                            for (std::size_t i = begin; i < end; ++i) {
                                const auto row = static_cast<Eigen::Index>(i);
                                rows.a.row(row).head(k) = gradient_of(conditions_[i]).transpose() * basis_;
                                rows.a(row, k) = -1.0;
                                rows.b[row] = -conditions_[i].value;
                            }
                        });
        add_bounds(rows, m);
        Eigen::VectorXd start = Eigen::VectorXd::Zero(k + 1);
        start[k] = margin;
        const Eigen::MatrixXd nothing = Eigen::MatrixXd::Zero(k + 1, k + 1);
        const Eigen::VectorXd towards = -Eigen::VectorXd::Unit(k + 1, k);
        const ConvexSolution best = solve_convex(nothing, towards, rows, start);
        if (!best.feasible) {
            throw InspectionError("the bounds of the borrowing contradict each other");
        }
        out.kkt_residual = kkt_residual(nothing, towards, rows, best);
        keep_proof(best, m, out);

        // From here on the smallest margin is a floor.
        rows.unknowns = k;
        rows.b.head(m).array() += best.y[k] - kKept;
        const auto [h, g] = unevenness();
        Eigen::VectorXd even = then(h, g, rows, best.y.head(k));
        // Least motion, where neither of the two sees a difference.
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(h);
        const double most = std::max(eigen.eigenvalues()[k - 1], 1e-300);
        std::vector<Eigen::Index> blind;
        for (Eigen::Index i = 0; i < k; ++i) {
            if (eigen.eigenvalues()[i] < 1e-9 * most || most < 1e-9) {
                blind.push_back(i);
            }
        }
        if (blind.empty()) {
            return even;
        }
        Eigen::MatrixXd free(k, static_cast<Eigen::Index>(blind.size()));
        for (std::size_t i = 0; i < blind.size(); ++i) {
            free.col(static_cast<Eigen::Index>(i)) = eigen.eigenvectors().col(blind[i]);
        }
        HalfSpaces last;
        last.a = rows.all() * free;
        last.b = rows.b - rows.all() * even;
        last.unknowns = free.cols();
        const Eigen::VectorXd so_far = free.transpose() * (even + basis_.transpose() * total_);
        const auto count = free.cols();
        return even + free * then(Eigen::MatrixXd::Identity(count, count), so_far, last, Eigen::VectorXd::Zero(count));
    }

    /// A further goal; where its rows leave no room at all, what is there already stays.
    static Eigen::VectorXd then(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const HalfSpaces& rows,
                                const Eigen::VectorXd& start) {
        const ConvexSolution solution = solve_convex(h, g, rows, start);
        return solution.feasible ? solution.y : start;
    }

    /// Variance of the allowance, mean over the faces that count, as a quadratic in the step (½ xᵀHx + gᵀx).
    [[nodiscard]] std::pair<Eigen::MatrixXd, Eigen::VectorXd> unevenness() const {
        Eigen::Matrix<double, 6, 6> h = Eigen::Matrix<double, 6, 6>::Zero();
        Vector6 right = Vector6::Zero();
        for (std::size_t i = 0; i < sums_.size(); ++i) {
            const Sums& s = sums_[i];
            if (groups_[i].evened && s.n > 0.0) {
                h += 2.0 * (s.whole() / s.n - s.g * s.g.transpose() / (s.n * s.n));
                right += 2.0 * (s.dg / s.n - s.d * s.g / (s.n * s.n));
            }
        }
        return {basis_.transpose() * h * basis_, basis_.transpose() * right};
    }

    [[nodiscard]] double variance() const {
        double sum = 0.0;
        double count = 0.0;
        for (std::size_t i = 0; i < sums_.size(); ++i) {
            const Sums& s = sums_[i];
            if (groups_[i].evened && s.n > 0.0) {
                const double mean = s.d / s.n;
                sum += std::max(s.dd / s.n - mean * mean, 0.0);
                count += 1.0;
            }
        }
        return count > 0.0 ? sum / count : 0.0;
    }

    void keep_proof(const ConvexSolution& best, Eigen::Index m, Borrowing& out) {
        out.active.clear();
        out.bounds.clear();
        found_.clear();
        for (std::size_t i = 0; i < best.active.size(); ++i) {
            const std::uint32_t row = best.active[i];
            if (row >= m) {
                const auto bound = static_cast<std::size_t>(row - m);
                out.bounds.push_back({bound / 2, bound % 2 == 1, best.multiplier[i]});
                continue;
            }
            const Condition& c = conditions_[row];
            out.active.push_back(
                {c.point, points_[c.point].group, c.upper, best.multiplier[i], c.value / kMm, c.place, c.direction});
            if (c.strip == kNoStrip && !c.upper && c.of_strip) {
                found_.push_back({c.point, c.place - values_[c.point] * c.direction, c.direction});
            }
        }
    }

    const FaceGauge* gauge_;
    std::span<const BorrowPoint> points_;
    std::span<const BorrowGroup> groups_;
    const BorrowOptions* options_;
    Vec3 centre_;
    Vec3 shift_;
    double length_;
    Eigen::MatrixXd basis_;
    Vector6 total_ = Vector6::Zero();  ///< mm: shift, turn · length
    Rigid<frame::W, frame::W> now_;    ///< the same as a motion
    std::vector<double> values_;       ///< heights at the last look, metres
    std::vector<Sums> sums_;           ///< of that look, one a group
    double margin_ = 0.0;              ///< mm, the smallest then
    std::vector<Condition> conditions_;
    std::vector<Strip> strips_;
    std::vector<Strip> found_;  ///< active in the last program, kept from the next round on
};

}  // namespace

Borrowing borrow(const DistanceField& field, const FaceGauge& gauge, std::span<const BorrowPoint> points,
                 std::span<const BorrowGroup> groups, const BorrowOptions& options) {
    if (points.empty()) {
        throw InspectionError("no point of the scan lies over a face that asks for anything: nothing to borrow");
    }
    return Borrower(field, gauge, points, groups, options).run();
}

Equalised equalise(double left, double right) noexcept {
    const double shift = 0.5 * std::abs(right - left);
    const double each = left < right ? left + shift : right + shift;
    return {shift, each, each};
}

}  // namespace sc::host
