// SPDX-License-Identifier: Apache-2.0
// The triple head from faces and readings given in files.
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "host/cli/triple_head_run.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kAxisX = -250.0;  ///< mm, of the table
constexpr double kAxisY = -470.0;
constexpr std::array<std::array<double, 4>, 3> kBeams{{
    // y, z (mm), leans towards y and z (mrad), from x = 150 mm towards -x
    {-490.1, -292.3, 1.4, -0.9},
    {-540.2, -378.8, -0.8, 1.1},
    {-439.9, -379.0, 0.6, 0.5},
}};
constexpr double kZero = 85.0;  ///< mm: what a sensor reads at no distance

/// A face that stands 60 mm off the table's axis, its normal at `at` degrees and up by `up`.
struct Side {
    int facet;
    double at;
    double up;
};
constexpr std::array kSides{Side{1, 0.0, 0.0}, Side{2, 90.0, 25.0}, Side{3, 180.0, -25.0}, Side{4, 270.0, 12.0}};

struct Plane {
    std::array<double, 3> normal;
    double distance;
};

Plane plane_of(const Side& side, double c_deg) {
    const double a = (side.at + c_deg) * std::numbers::pi / 180.0;
    const double e = side.up * std::numbers::pi / 180.0;
    const std::array<double, 3> n{std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
    const std::array<double, 3> on{kAxisX + 60.0 * std::cos(a), kAxisY + 60.0 * std::sin(a), -350.0};
    return {n, n[0] * on[0] + n[1] * on[1] + n[2] * on[2]};
}

class TripleHeadFiles : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ = fs::path(::testing::TempDir()) / fmt::format("triple_head_{}", ::getpid());
        fs::create_directories(folder_);
        CalibrationSet set;
        set.id = "bench";
        set.time = "2026-01-01T00:00:00Z";
        const Provenance made{.parents = {}, .residual_rms = 0.0, .time = set.time, .note = {}};
        set.transforms.push_back(
            {.id = "h_from_c", .rotation = Mat3::identity(), .translation = {}, .covariance = {}, .provenance = made});
        set.turntable = AxisRecord{
            .line = {{{kAxisX * 1e-3, kAxisY * 1e-3, 0.0}}, {{0.0, 0.0, 1.0}}}, .covariance = {}, .provenance = made};
        for (std::size_t i = 0; i < 6; ++i) {
            set.transforms.front().covariance.at[i][i] = 1e-12;
            if (i < 4) {
                set.turntable->covariance.at[i][i] = 1e-12;
            }
        }
        static_cast<void>(write_calibration(folder_ / "set.toml", set));
        write_points([](const Side&, int) { return 0.0; });
        write_readings([](int sensor) { return sensor; });
    }
    void TearDown() override { fs::remove_all(folder_); }

    /// Sixteen points a face; each with the table's angle when it was seen.
    void write_points(const std::function<double(const Side&, int)>& c_deg) {
        std::string text = "facet,x_mm,y_mm,z_mm,c_deg\n";
        for (const Side& side : kSides) {
            const Plane plane = plane_of(side, 0.0);
            const double a = side.at * std::numbers::pi / 180.0;
            for (int i = 0; i < 16; ++i) {
                // Across the normal's foot, and up; then along the normal onto the plane.
                const double across = -60.0 + 40.0 * (i % 4);
                std::array<double, 3> p{kAxisX + 60.0 * std::cos(a) - across * std::sin(a),
                                        kAxisY + 60.0 * std::sin(a) + across * std::cos(a), -400.0 + 30.0 * (i / 4)};
                double off = plane.distance;
                for (std::size_t k = 0; k < 3; ++k) {
                    off -= plane.normal.at(k) * p.at(k);
                }
                for (std::size_t k = 0; k < 3; ++k) {
                    p.at(k) += off * plane.normal.at(k);
                }
                text += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.3f}\n", side.facet, p[0], p[1], p[2], c_deg(side, i));
            }
        }
        write_text_file(folder_ / "points.csv", text);
    }
    void write_readings(const std::function<int(int)>& number) {
        std::string text = "sensor,facet,c_deg,reading_mm,sigma_mm\n";
        for (const Side& side : kSides) {
            for (const double swing : {-15.0, -10.0, -5.0, 0.0, 5.0, 10.0, 15.0}) {
                const double c_deg = swing - side.at;
                const Plane plane = plane_of(side, c_deg);
                for (std::size_t k = 0; k < kBeams.size(); ++k) {
                    const auto& [y, z, to_y, to_z] = kBeams[k];
                    std::array<double, 3> d{-1.0, 1e-3 * to_y, 1e-3 * to_z};
                    const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
                    double along = plane.distance - plane.normal[0] * 150.0 - plane.normal[1] * y - plane.normal[2] * z;
                    along /= (plane.normal[0] * d[0] + plane.normal[1] * d[1] + plane.normal[2] * d[2]) / length;
                    text += fmt::format("{},{},{:.3f},{:.6f},0.002\n", number(static_cast<int>(k) + 1), side.facet,
                                        c_deg, along + kZero);
                }
            }
        }
        write_text_file(folder_ / "readings.csv", text);
    }
    [[nodiscard]] TripleHeadOptions options() const {
        TripleHeadOptions out;
        out.out = folder_ / "out";
        out.points = folder_ / "points.csv";
        out.readings = folder_ / "readings.csv";
        out.calibration = folder_ / "set.toml";
        return out;
    }
    [[nodiscard]] std::string refusal() const {
        try {
            static_cast<void>(run_triple_head(options()));
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }

    fs::path folder_;
};

TEST_F(TripleHeadFiles, FindsTheThreeBeamsAndWritesThem) {
    const TripleHeadOutcome found = run_triple_head(options());
    for (std::size_t k = 0; k < kBeams.size(); ++k) {
        const SensorRayFit& ray = found.fit.rays.at(k);
        const double way = 150.0 - ray.origin.x * 1e3;
        EXPECT_NEAR(ray.origin.y * 1e3, kBeams[k][0] + 1e-3 * way * kBeams[k][2], 2e-3) << k;
        EXPECT_NEAR(ray.origin.z * 1e3, kBeams[k][1] + 1e-3 * way * kBeams[k][3], 2e-3) << k;
        EXPECT_NEAR(ray.direction.y, 1e-3 * kBeams[k][2], 5e-5) << k;
        EXPECT_NEAR(ray.direction.z, 1e-3 * kBeams[k][3], 5e-5) << k;
    }
    EXPECT_EQ(read_calibration(found.files).triple_head.size(), 3U);
}

TEST_F(TripleHeadFiles, RefusesAFourthSensor) {
    write_readings([](int sensor) { return sensor == 3 ? 4 : sensor; });
    const std::string said = refusal();
    EXPECT_NE(said.find("readings.csv:4"), std::string::npos) << said;
    EXPECT_NE(said.find("sensors 1, 2 and 3"), std::string::npos) << said;
    EXPECT_FALSE(fs::exists(folder_ / "out/calibration.toml"));
}

TEST_F(TripleHeadFiles, RefusesAFaceSeenAtTwoAngles) {
    write_points([](const Side& side, int i) { return side.facet == 2 && i > 7 ? 5.0 : 0.0; });
    const std::string said = refusal();
    EXPECT_NE(said.find("points.csv"), std::string::npos) << said;
    EXPECT_NE(said.find("angle"), std::string::npos) << said;
}

TEST_F(TripleHeadFiles, RefusesASetWithoutATurntable) {
    CalibrationSet set = read_calibration(folder_ / "set.toml");
    set.turntable.reset();
    static_cast<void>(write_calibration(folder_ / "set.toml", set));
    const std::string said = refusal();
    EXPECT_NE(said.find("turntable"), std::string::npos) << said;
}

}  // namespace
}  // namespace sc::host::cli
