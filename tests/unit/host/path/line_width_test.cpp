// SPDX-License-Identifier: Apache-2.0
#include "host/path/line_width.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "sample_job.hpp"

namespace sc::host {
namespace {

using namespace literals;

constexpr double kClose = 1e-12;

MarkSettings wide(Fill fill, double width, double step) {
    MarkSettings settings = sample::galvo_settings();
    settings.width = Length::from_si(width);
    settings.fill = fill;
    settings.fill_step = Length::from_si(step);
    return settings;
}

std::vector<Piece> polyline(const std::vector<Vec3>& places) {
    std::vector<Piece> pieces;
    for (std::size_t i = 1; i < places.size(); ++i) {
        pieces.push_back({places[i - 1], places[i], std::nullopt, static_cast<int>(i)});
    }
    return pieces;
}

double distance(const std::vector<Piece>& pieces, const Vec3& at) {
    double least = 1.0;
    for (const Piece& piece : pieces) {
        least = std::min(least, nearest(piece, at).distance);
    }
    return least;
}

void expect_joined(const std::vector<Piece>& pieces) {
    for (std::size_t i = 1; i < pieces.size(); ++i) {
        EXPECT_LT(norm(pieces[i].from - pieces[i - 1].to), kClose);
    }
}

void expect_refused(const std::vector<Piece>& line, const MarkSettings& settings, int at, std::string_view problem) {
    try {
        static_cast<void>(strokes_of(line, settings));
        ADD_FAILURE() << "not refused: " << problem;
    } catch (const LineWidthError& error) {
        EXPECT_NE(std::string_view(error.what()).find(problem), std::string_view::npos) << error.what();
        EXPECT_EQ(error.line, at);
        EXPECT_FALSE(error.action.empty());
    }
}

void expect_input_refused(const std::function<void()>& action, std::string_view problem) {
    const InputError error = sample::refusal_of(action);
    EXPECT_NE(error.problem().find(problem), std::string::npos) << error.what();
}

TEST(LineWidth, AThinLineIsItself) {
    const auto line = polyline({{0.0, 0.0, 0.0}, {0.01, 0.001, 0.0}});
    const Strokes strokes = strokes_of(line, sample::galvo_settings());
    ASSERT_EQ(strokes.pieces.size(), 1U);
    EXPECT_EQ(strokes.pieces[0][0].to, line[0].to);
    EXPECT_EQ(strokes.tolerance, sample::galvo_settings().tolerance.si());
}

TEST(LineWidth, AHatchCoversTheWidthEvenlyThereAndBack) {
    const auto line = polyline({{0.0, 0.0, 0.0}, {0.01, 0.001, 0.0}});
    // 0.25 mm in steps of 0.06 at most: five gaps of 0.05.
    const Strokes strokes = strokes_of(line, wide(Fill::hatch, 0.25e-3, 0.06e-3));
    ASSERT_EQ(strokes.pieces.size(), 6U);
    for (std::size_t k = 0; k < 6; ++k) {
        const Piece& stroke = strokes.pieces[k].front();
        const double z = 0.125e-3 - 0.05e-3 * static_cast<double>(k);
        EXPECT_NEAR(stroke.from.z, z, kClose);
        EXPECT_NEAR(stroke.to.z, z, kClose);
        const bool back = k % 2 == 1;
        EXPECT_NEAR(stroke.from.x, back ? 0.01 : 0.0, kClose);
        EXPECT_NEAR(stroke.from.y, back ? 0.001 : 0.0, kClose) << "the depth of the line";
    }
    EXPECT_EQ(strokes.tolerance, 5e-6) << "no chords, nothing taken";
}

TEST(LineWidth, CornersOfAHatchAreMitredOpenAndClosed) {
    const auto square =
        polyline({{0.0, 0.0, 0.0}, {0.01, 0.0, 0.0}, {0.01, 0.0, 0.01}, {0.0, 0.0, 0.01}, {0.0, 0.0, 0.0}});
    const Strokes strokes = strokes_of(square, wide(Fill::hatch, 1e-3, 1e-3));
    ASSERT_EQ(strokes.pieces.size(), 2U);
    for (const auto& stroke : strokes.pieces) {
        expect_joined(stroke);
        EXPECT_LT(norm(stroke.front().from - stroke.back().to), kClose) << "closed";
        const double side = stroke.front().length();
        EXPECT_TRUE(std::abs(side - 0.009) < kClose || std::abs(side - 0.011) < kClose) << side;
        for (const Piece& piece : stroke) {
            EXPECT_NEAR(distance(square, piece.at(0.5)), 0.5e-3, kClose);
        }
    }
    auto open = square;
    open.pop_back();
    for (const auto& stroke : strokes_of(open, wide(Fill::hatch, 1e-3, 1e-3)).pieces) {
        EXPECT_LT(std::abs(stroke.front().from.x), kClose) << "an open end is cut square";
        EXPECT_LT(std::abs(stroke.back().to.x), kClose);
    }
}

TEST(LineWidth, AHatchedCircleStaysBesideItWithinATenthOfTheTolerance) {
    std::vector<Piece> circle;
    const Vec3 left{-0.005, 0.0, 0.0};
    const Vec3 right{0.005, 0.0, 0.0};
    circle.push_back({left, right, circle_through(left, {0.0, 0.0, 0.005}, right), 1});
    circle.push_back({right, left, circle_through(right, {0.0, 0.0, -0.005}, left), 2});
    const Strokes strokes = strokes_of(circle, wide(Fill::hatch, 0.4e-3, 0.2e-3));
    ASSERT_EQ(strokes.pieces.size(), 3U);
    EXPECT_NEAR(strokes.tolerance, 4.5e-6, kClose);
    for (std::size_t k = 0; k < 3; ++k) {
        const double first = norm(strokes.pieces[k].front().from);
        for (const Piece& piece : strokes.pieces[k]) {
            for (const double share : {0.0, 0.3, 0.5, 0.9}) {
                // Mitred chords: a stroke's corners stand out by as much as its middles fall short.
                EXPECT_NEAR(norm(piece.at(share)), 0.005 + (first > 0.0051 ? 0.2e-3 : (first < 0.0049 ? -0.2e-3 : 0.0)),
                            0.6e-6);
            }
        }
    }
}

TEST(LineWidth, AWobbleGoesRoundAsOftenAsAskedWithinHalfTheWidth) {
    const auto line = polyline({{0.0, 0.0, 0.0}, {0.004, 0.0, 0.0}, {0.004, 0.0005, 0.003}});
    MarkSettings settings = wide(Fill::wobble, 0.3e-3, 0.1e-3);
    settings.speed = Speed::from_si(0.06);
    const Strokes strokes = strokes_of(line, settings);
    ASSERT_EQ(strokes.pieces.size(), 1U);
    const auto& stroke = strokes.pieces[0];
    expect_joined(stroke);
    EXPECT_NEAR(strokes.tolerance, 4.5e-6, kClose);
    double around = 0.0;
    for (std::size_t i = 0; i < stroke.size(); ++i) {
        EXPECT_LE(distance(line, stroke[i].to), 0.15e-3 + kClose);
        if (i > 0) {
            const Vec3 a = stroke[i - 1].direction(0.5);
            const Vec3 b = stroke[i].direction(0.5);
            around += std::atan2(a.x * b.z - a.z * b.x, a.x * b.x + a.z * b.z);
        }
    }
    const double turns = length(line) / 0.1e-3;
    EXPECT_NEAR(around / (2.0 * std::numbers::pi), turns, 0.6);
    EXPECT_NEAR(length(stroke), turns * std::numbers::pi * 0.3e-3, 0.05 * length(stroke) + 0.1e-3 * turns);
}

TEST(LineWidth, RefusesWhatCannotBeFilled) {
    const MarkSettings hatch = wide(Fill::hatch, 1e-3, 0.1e-3);
    expect_refused(polyline({{0.0, 0.0, 0.0}, {0.0, 0.01, 0.0}}), hatch, 1, "along the beam");
    expect_refused(polyline({{0.0, 0.0, 0.0}, {0.01, 0.0, 0.0}, {0.002, 0.0, 0.001}}), hatch, 1, "too sharp");
    expect_refused(polyline({{0.0, 0.0, 0.0}, {0.01, 0.0, 0.0}, {0.01, 0.0, 0.0002}, {0.0, 0.0, 0.0002}}), hatch, 2,
                   "too narrow");
    expect_refused(polyline({{0.0, 0.0, 0.0}, {0.01, 0.0, 0.0}}), wide(Fill::hatch, 5e-3, 0.01e-3), 0,
                   "too many strokes");
    expect_refused(polyline({{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}), wide(Fill::wobble, 5e-3, 1e-6), 0, "too many points");
    MarkSettings fast = wide(Fill::wobble, 0.2e-3, 0.06e-3);
    fast.speed = Speed::from_si(0.25);
    expect_refused(polyline({{0.0, 0.0, 0.0}, {0.01, 0.0, 0.0}}), fast, 0, "points a second");
}

/// A line of two passes and a hatch of three strokes: six passes of one path, no two with the same number.
TEST(LineWidth, StrokesOfAJobCountAsPassesAndStayInTheMachine) {
    Job job = sample::job();
    job.cross.reset();
    job.datum_line->settings.width = 200_um;
    job.datum_line->settings.fill_step = 100_um;
    job.datum_line->settings.passes = 2;
    const JobPlan plan = sample::plan(job, sample::table());
    ASSERT_EQ(plan.paths.size(), 2U);
    EXPECT_EQ(plan.paths[0].kind, PathKind::free_path);
    EXPECT_EQ(plan.paths[0].strokes.size(), 3U);
    std::set<std::pair<std::uint32_t, std::uint8_t>> passes;
    for (const Item& item : plan.items) {
        if (const auto* begin = std::get_if<PathBegin>(&item)) {
            passes.insert({begin->path, begin->pass});
        }
    }
    EXPECT_EQ(passes.size(), 12U);
    job.datum_line->settings.width = Length::from_si(0.4);
    job.datum_line->settings.fill_step = 10_mm;
    expect_input_refused([&] { static_cast<void>(sample::plan(job, sample::table())); }, "out of the travel");
}

TEST(LineWidth, ACrossHasOneStroke) {
    Job job = sample::job();
    job.cross->settings.width = 200_um;
    job.cross->settings.fill_step = 100_um;
    expect_input_refused([&] { static_cast<void>(sample::plan(job, sample::table())); }, "one stroke each way");
}

Job tilted(Actuator actuator) {
    Job job = sample::job();
    job.cross.reset();
    job.datum_line.reset();
    job.faces.clear();
    JobPath path;
    path.name = "slope";
    path.line = 9;
    path.settings = actuator == Actuator::galvo ? sample::galvo_settings() : sample::axes_settings();
    path.steps = {{10, std::nullopt, {-0.26, -0.300, -0.40}}, {11, std::nullopt, {-0.24, -0.299, -0.40}}};
    job.paths.push_back(path);
    return job;
}

TEST(DepthWindow, FollowsFromTheFluenceToleranceAndTheBeam) {
    const BeamRecord beam{.waist = 25e-6, .rayleigh_length = 0.6e-3, .time = {}, .note = {}};
    // Half the area more at z: peak fluence 1 / (1 + (z / z_R)²).
    EXPECT_NEAR(beam.depth_within(0.5), 0.6e-3, kClose);
    EXPECT_NEAR(1.0 / (1.0 + std::pow(beam.depth_within(0.2) / 0.6e-3, 2)), 0.8, kClose);
    CalibrationSet set = sample::calibration();
    const auto plan = [&set](const Job& job) { return plan_job(job, sample::table(), set, reference_machine(), {}); };
    // 0.5 mm either side of the middle; 20 % allow 0.3 mm.
    EXPECT_NO_THROW(static_cast<void>(plan(tilted(Actuator::galvo)))) << "a beam that is not known is not judged";
    set.beam = beam;
    expect_input_refused([&] { static_cast<void>(plan(tilted(Actuator::galvo))); }, "fluence stays within 20 %");
    EXPECT_NO_THROW(static_cast<void>(plan(tilted(Actuator::axes)))) << "y follows the surface";
    Job loose = tilted(Actuator::galvo);
    loose.paths[0].settings.fluence_tolerance = 0.45;
    EXPECT_NO_THROW(static_cast<void>(plan(loose)));
}

}  // namespace
}  // namespace sc::host
