// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/scribe_budget.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "host/calibration/set_diff.hpp"
#include "host/formats/calibration_records.hpp"
#include "host/formats/error.hpp"
#include "host/formats/table.hpp"

namespace sc::host {
namespace {

const std::filesystem::path kExamples = SC_SOURCE_DIR "/examples/ras3dm";

/// A second way from numbers to a place, by quaternions and for whole draws: shares nothing with the propagation.
class Drawn {
public:
    explicit Drawn(std::uint64_t seed) : random_(seed) {}

    /// A draw with this covariance (Cholesky by hand).
    std::vector<double> draw(const std::vector<std::vector<double>>& covariance) {
        const std::size_t n = covariance.size();
        std::vector<std::vector<double>> l(n, std::vector<double>(n, 0.0));
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = 0; j <= i; ++j) {
                double sum = covariance[i][j];
                for (std::size_t k = 0; k < j; ++k) {
                    sum -= l[i][k] * l[j][k];
                }
                l[i][j] = i == j ? std::sqrt(std::max(sum, 0.0)) : (l[j][j] > 0.0 ? sum / l[j][j] : 0.0);
            }
        }
        std::vector<double> white(n);
        for (double& w : white) {
            w = one_(random_);
        }
        std::vector<double> out(n, 0.0);
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = 0; j <= i; ++j) {
                out[i] += l[i][j] * white[j];
            }
        }
        return out;
    }
    double normal() { return one_(random_); }
    Vec3 normal3(double sigma) { return {sigma * normal(), sigma * normal(), sigma * normal()}; }

    static Vec3 turned(const Vec3& p, const Vec3& w) {
        const double angle = norm(w);
        if (!(angle > 0.0)) {
            return p;
        }
        const Vec3 u = (1.0 / angle) * w;
        const Vec3 q = std::sin(0.5 * angle) * u;
        const Vec3 t = 2.0 * cross(q, p);
        return p + std::cos(0.5 * angle) * t + cross(q, t);
    }

private:
    std::mt19937_64 random_;
    std::normal_distribution<double> one_{0.0, 1.0};
};

struct Case {
    CalibrationSet set;
    BudgetNoise noise;
    BudgetPlace place;
};

/// Where the cell would burn, for one draw of all that is uncertain.
Vec3 burnt(const Case& c, const Vec3& in_c, Drawn& drawn, const std::vector<double>& all) {
    const Vec3 seen = in_c + drawn.normal3(c.noise.sensor);
    const TransformRecord& x = c.set.transforms[0];
    Vec3 p = x.rotation * seen + x.translation;
    p = Drawn::turned(p, {all[0], all[1], all[2]}) + Vec3{all[3], all[4], all[5]};
    Vec3 a = c.set.turntable->line.point.v;
    Vec3 d = c.set.turntable->line.direction.v;
    a = a + Vec3{all[6], all[7], 0.0};
    d = d + Vec3{all[8], all[9], 0.0};
    d = (1.0 / norm(d)) * d;
    const double angle = -c.place.face_deg * 3.14159265358979323846 / 180.0 + c.noise.turn * drawn.normal();
    p = a + Drawn::turned(p - a, angle * d);
    const Vec3 q = p;
    p = q + Vec3{all[10] * q.y + all[11] * q.z + all[13] * q.x, all[12] * q.z + all[14] * q.y, all[15] * q.z};
    p = p + Vec3{all[16] + all[18] * c.noise.field[0] + all[19] * c.noise.field[1], 0.0,
                 all[17] + all[20] * c.noise.field[0] + all[21] * c.noise.field[1]};
    return p + drawn.normal3(c.noise.axes);
}

Case example(double correlation) {
    Case c;
    c.set = read_calibration(kExamples / "calibration.toml");
    c.set.galvo_field.reset();
    c.noise.field = {0.012, -0.015};
    // A good deal larger than the example's, so that every source shows.
    for (auto& row : c.set.turntable->covariance.at) {
        for (double& v : row) {
            v *= 60.0;
        }
    }
    if (correlation != 0.0) {
        CrossCovariance cross{.between = {"h_from_c", "turntable"}, .at = {6, std::vector<double>(4, 0.0)}};
        for (const std::size_t i : {0U, 1U}) {
            cross.at[3 + i][i] = correlation * std::sqrt(c.set.transforms[0].covariance.at[3 + i][3 + i] *
                                                         c.set.turntable->covariance.at[i][i]);
        }
        c.set.cross = {cross};
    }
    c.place = {.name = "1", .face_deg = 90.0, .place = {{-0.224815, -0.285691, -0.404515}}};
    return c;
}

/// Back to c by hand.
Vec3 in_c(const Case& c) {
    const Vec3 a = c.set.turntable->line.point.v;
    const Vec3 d = c.set.turntable->line.direction.v;
    const double angle = c.place.face_deg * 3.14159265358979323846 / 180.0;
    const Vec3 p = a + Drawn::turned(c.place.place.v - a, (angle / norm(d)) * d);
    return c.set.transforms[0].rotation.transposed() * (p - c.set.transforms[0].translation);
}

void compare_with_draws(const Case& c, std::uint64_t seed) {
    const PlaceBudget budget = scribe_budget(c.set, {c.place}, c.noise).places.front();
    const auto joint = joint_covariance(c.set, covariance_blocks(c.set));  // h_from_c, turntable, axes, galvo
    ASSERT_EQ(joint.size(), 22U);
    Drawn drawn(seed);
    const Vec3 place = in_c(c);
    constexpr int kDraws = 20000;
    std::vector<Vec3> all;
    Vec3 mean;
    for (int i = 0; i < kDraws; ++i) {
        all.push_back(burnt(c, place, drawn, drawn.draw(joint)));
        mean = mean + (1.0 / kDraws) * all.back();
    }
    EXPECT_NEAR(norm(mean - c.place.place.v), 0.0, 0.5e-6);
    std::vector<double> lengths;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            double sum = 0.0;
            for (const Vec3& p : all) {
                sum += (p[i] - mean[i]) * (p[j] - mean[j]) / kDraws;
            }
            const double scale = std::sqrt(budget.total[i][i] * budget.total[j][j]);
            EXPECT_NEAR(sum, budget.total[i][j], 0.04 * scale) << i << " " << j;
        }
    }
    std::size_t within = 0;
    std::size_t along_x = 0;
    for (const Vec3& p : all) {
        within += norm(p - mean) <= budget.distance_95 ? 1U : 0U;
        along_x += std::abs(p.x - mean.x) <= budget.axis_95.x ? 1U : 0U;
    }
    EXPECT_NEAR(static_cast<double>(within) / kDraws, 0.95, 0.008);
    EXPECT_NEAR(static_cast<double>(along_x) / kDraws, 0.95, 0.006);
}

TEST(ScribeBudget, AgreesWithDraws) { compare_with_draws(example(0.0), 1); }
TEST(ScribeBudget, TakesInWhatRecordsShare) {
    compare_with_draws(example(0.35), 2);
    const auto without = scribe_budget(example(0.0).set, {example(0.0).place}).places.front();
    const auto with = scribe_budget(example(0.35).set, {example(0.35).place}).places.front();
    EXPECT_GT(std::abs(with.total[0][0] - without.total[0][0]), 0.02 * without.total[0][0]);
    EXPECT_EQ(with.sources.back().name, "shared");
}

TEST(ScribeBudget, SourcesMakeUpTheTotal) {
    Case c = example(0.3);
    c.noise.pointing = 55e-6;
    const PlaceBudget budget = scribe_budget(c.set, {c.place}, c.noise).places.front();
    for (std::size_t i = 0; i < 3; ++i) {
        double sum = 0.0;
        for (const BudgetSource& source : budget.sources) {
            sum += source.covariance[i][i];
        }
        EXPECT_NEAR(sum, budget.total[i][i], 1e-18);
    }
    EXPECT_GT(budget.checked_95, 1.95 * 55e-6);
    EXPECT_LT(budget.axis_95.x, 1.95 * 55e-6) << "pointing is no error of scribing";
}

TEST(ScribeBudget, AWayThroughInverseTransformsIsTheSame) {
    Case c = example(0.0);
    c.set.cross.clear();
    const PlaceBudget direct = scribe_budget(c.set, {c.place}).places.front();
    // h_from_c as the inverse of c_from_h: ξ' = −Ad ξ, so Σ' = Ad Σ Adᵀ with p' = Rᵀ(p − t).
    TransformRecord& x = c.set.transforms[0];
    const Mat3 r = x.rotation.transposed();
    const Vec3 t = -(r * x.translation);
    std::array<std::array<double, 6>, 6> adjoint{};
    const std::array<Vec3, 3> columns{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 turned = r * columns.at(k);
        const Vec3 moved = cross(t, turned);
        for (std::size_t i = 0; i < 3; ++i) {
            adjoint.at(i).at(k) = turned[i];
            adjoint.at(3 + i).at(k) = moved[i];
            adjoint.at(3 + i).at(3 + k) = turned[i];
        }
    }
    Covariance<6> moved;
    for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < 6; ++j) {
            for (std::size_t k = 0; k < 6; ++k) {
                for (std::size_t l = 0; l < 6; ++l) {
                    moved.at[i][j] += adjoint.at(i).at(k) * x.covariance.at[k][l] * adjoint.at(j).at(l);
                }
            }
        }
    }
    x = {.id = "c_from_h", .rotation = r, .translation = t, .covariance = moved, .provenance = x.provenance};
    const PlaceBudget inverse = scribe_budget(c.set, {c.place}).places.front();
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            EXPECT_NEAR(inverse.total[i][j], direct.total[i][j], 1e-6 * direct.total[0][0]);
        }
    }
    c.set.transforms.clear();
    EXPECT_THROW(static_cast<void>(scribe_budget(c.set, {c.place})), InputError);
}

TEST(SetDiff, SaysHowFarAPlaceIsMoved) {
    const CalibrationSet a = read_calibration(kExamples / "calibration.toml");
    const Vec3 at = default_place(a);
    const SetDiff none = diff_sets(a, a, at);
    EXPECT_TRUE(std::ranges::all_of(none.records, [](const RecordDiff& r) { return r.change == RecordChange::same; }));
    CalibrationSet b = a;
    b.transforms[0].translation = a.transforms[0].translation + Vec3{45e-6, 0.0, 0.0};
    b.turntable->line.point.v = a.turntable->line.point.v + Vec3{0.0, 5e-6, 0.0};
    b.beam.reset();
    b.y_sensor.reset();
    const SetDiff diff = diff_sets(a, b, at);
    const auto of = [&diff](const std::string& id) { return *std::ranges::find(diff.records, id, &RecordDiff::id); };
    EXPECT_NEAR(of("h_from_c").moves->x, 45e-6, 1e-12);
    EXPECT_NEAR(of("h_from_c").moves->y, 0.0, 1e-12);
    // δᵀ Σ⁻¹ δ of a shift in x alone is what is left of x with the rest known: more than by its own variance.
    const double alone = 45e-6 / std::sqrt(2.0 * a.transforms[0].covariance.at[3][3]);
    EXPECT_GT(*of("h_from_c").sigmas, alone / std::sqrt(6.0));
    EXPECT_LT(*of("h_from_c").chance, 0.05);
    // At 180 degrees a place goes to 2a − p: twice as far as the axis.
    EXPECT_NEAR(norm(*of("turntable").moves), 10e-6, 0.1e-6);
    EXPECT_NEAR(*of("turntable").sigmas, std::sqrt(25e-12 / 2e-12 / 4.0), 1e-2);
    EXPECT_EQ(of("y_sensor").change, RecordChange::removed);
}

}  // namespace
}  // namespace sc::host
