// SPDX-License-Identifier: Apache-2.0
#include "host/registration/chain.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"
#include "tests/unit/host/registration/cell.hpp"

namespace sc::host {
namespace {

using test::Cell;
using test::kDegree;

std::string refusal(const std::function<void()>& work) {
    try {
        work();
    } catch (const InputError& error) {
        return error.what();
    }
    return "nothing was refused";
}

TEST(Chain, ViewsMarkersAxisAndTransformAreFoundWithinTheirUncertainty) {
    Cell cell(1);
    cell.look_around(12);
    cell.point();
    ChainOptions options;
    for (int id = 1; id <= 8; ++id) {
        options.predict.push_back({id, 90.0});
    }
    const ChainResult result = fit_chain(cell.input, options);
    EXPECT_TRUE(result.findings.empty());
    EXPECT_NEAR(result.chi_squared, result.freedom, 5.0 * std::sqrt(2.0 * result.freedom));
    for (std::size_t i = 0; i < result.views.size(); ++i) {
        EXPECT_LT(norm(result.views[i].translation - cell.origin(i)), 60e-6) << i;
    }
    ASSERT_TRUE(result.h_from_c && result.axis_in_h && result.together);
    ASSERT_EQ(result.places.size(), 8U);
    for (const ChainPlace& p : result.places) {
        const Vec3 off = p.place - cell.in_h(p.id, -90.0);
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_LT(std::abs(off[k]), 4.0 * std::sqrt(p.covariance.at[k][k])) << p.id;
            EXPECT_LT(std::sqrt(p.covariance.at[k][k]), 20e-6);
        }
    }
    const Vec3 direction = cell.h_from_ground.rotation * cell.axis;
    EXPECT_LT(norm(result.axis_in_h->line.direction.v - direction), 3e-4);
}

TEST(Chain, StatedCovarianceOfPlacesHolds) {
    double inside = 0.0;
    double places = 0.0;
    for (unsigned seed = 1; seed <= 40; ++seed) {
        Cell cell(seed);
        cell.look_around(6);
        cell.point();
        ChainOptions options;
        options.axes = 0.0;
        options.table = 8.73e-6;
        options.predict = {{1, 0.0}, {5, 180.0}};
        for (const ChainPlace& p : fit_chain(cell.input, options).places) {
            const Vec3 off = p.place - cell.in_h(p.id, -p.face_deg);
            for (std::size_t k = 0; k < 3; ++k) {
                inside += std::abs(off[k]) <= 1.96 * std::sqrt(p.covariance.at[k][k]) ? 1.0 : 0.0;
                places += 1.0;
            }
        }
    }
    EXPECT_GT(inside / places, 0.89);  // 240 values, of which some stand together
    EXPECT_LT(inside / places, 0.995);
}

TEST(Chain, PlacesByTransformAndAxisHaveTheCovarianceOfBothTogether) {
    // Of a place fixed in c, by finite differences of ξ and axis, against predict() less the marker's own part.
    Cell cell(2);
    cell.look_around(8);
    cell.point();
    const ChainResult result = fit_chain(cell.input);
    ASSERT_TRUE(result.together);
    for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < 6; ++j) {
            EXPECT_DOUBLE_EQ(result.together->at[i][j], result.h_from_c->covariance.at[i][j]);
        }
    }
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_GT(result.together->at[6 + i][6 + i], 0.0);
        EXPECT_DOUBLE_EQ(result.together->at[6 + i][6 + i], result.axis_in_h->covariance.at[i][i]);
    }
    // The axis's place in h moves with h_from_c.
    double coupled = 0.0;
    for (std::size_t i = 0; i < 6; ++i) {
        coupled = std::max(coupled, std::abs(result.together->at[i][6]) /
                                        std::sqrt(result.together->at[i][i] * result.together->at[6][6]));
    }
    EXPECT_GT(coupled, 0.2);
}

TEST(Chain, WrongSightingsAreNamedAndDoNoHarm) {
    Cell cell(3);
    cell.look_around(10);
    cell.point();
    ChainInput clean = cell.input;
    cell.input.views[4].seen.markers[2].place = cell.input.views[4].seen.markers[2].place + Vec3{2e-3, -1e-3, 0.0};
    cell.input.views[7].seen.markers[5].place = cell.input.views[7].seen.markers[5].place + Vec3{0.0, 0.0, 1.5e-4};
    const ChainResult result = fit_chain(cell.input);
    ASSERT_EQ(result.findings.size(), 2U);
    for (const MarkerFinding& f : result.findings) {
        EXPECT_TRUE((f.view == "v5" && f.id == cell.input.views[4].seen.markers[2].id) ||
                    (f.view == "v8" && f.id == cell.input.views[7].seen.markers[5].id))
            << f.text();
    }
    const ChainResult sound = fit_chain(clean);
    EXPECT_LT(norm(result.h_from_c->translation - sound.h_from_c->translation), 20e-6);
}

TEST(Chain, AWrongMarkerInTheFirstViewIsNamedThereAndNotInAllOthers) {
    Cell cell(4);
    cell.look_around(6);
    cell.input.views[0].seen.markers[1].place = cell.input.views[0].seen.markers[1].place + Vec3{4e-3, 0.0, 0.0};
    const ChainResult result = fit_chain(cell.input);
    ASSERT_EQ(result.findings.size(), 1U);
    EXPECT_EQ(result.findings[0].view, "v1");
}

TEST(Chain, AViewThatFitsNoOtherIsLeftOutAndNamed) {
    Cell cell(20);
    cell.look_around(8);
    cell.point();
    for (SeenMarker& m : cell.input.views[3].seen.markers) {
        m.place = m.place + cell.draw(0.03);
    }
    const ChainResult result = fit_chain(cell.input);
    EXPECT_EQ(result.bad_views, std::vector<std::string>{"v4"});
    ASSERT_EQ(result.views.size(), 7U);
    EXPECT_EQ(result.views[3].name, "v5");
    EXPECT_LT(norm(result.views[3].translation - cell.origin(4)), 60e-6);
    ASSERT_FALSE(result.notes.empty());
    EXPECT_NE(result.notes[0].find("v4 is left out"), std::string::npos) << result.notes[0];
}

TEST(Chain, SwappedNumbersArePutRight) {
    Cell cell(5);
    cell.look_around(8);
    auto& markers = cell.input.views[3].seen.markers;
    std::swap(markers[0].id, markers[3].id);
    const ChainResult result = fit_chain(cell.input);
    ASSERT_EQ(result.findings.size(), 1U);
    EXPECT_EQ(result.findings[0].kind, MarkerFinding::Kind::swapped);
    EXPECT_EQ(result.findings[0].view, "v4");
    EXPECT_NEAR(result.chi_squared / result.freedom, 1.0, 0.2);
}

TEST(Chain, AnAngleReadWrongIsNamedAndItsMarkersStillCount) {
    for (const double off_deg : {0.05, 25.0}) {
        Cell cell(6);
        cell.look_around(10);
        cell.point();
        cell.input.views[5].seen.turn = *cell.input.views[5].seen.turn + off_deg * kDegree;
        const ChainResult result = fit_chain(cell.input);
        EXPECT_TRUE(result.views[5].turn_wrong) << off_deg;
        EXPECT_NEAR(result.views[5].turn_off / kDegree, -off_deg, 0.01);
        EXPECT_TRUE(result.findings.empty()) << result.findings.front().text();
        EXPECT_EQ(std::ranges::count(result.views, true, &ChainViewResult::turn_wrong), 1);
    }
}

TEST(Chain, RobotPosesCountByTheNoiseThatTheyShow) {
    Cell cell(7);
    cell.look_around(12);
    cell.point();
    const ChainResult without = fit_chain(cell.input);
    EXPECT_EQ(without.robot_ratio, 0.0);
    const Rigid<frame::F, frame::C> mount{test::turn(0.7, {1.0, 2.0, 0.5}), {0.03, -0.02, 0.1}};
    const Rigid<frame::B, frame::C> base{test::turn(1.9, {0.2, -0.3, 1.0}), {1.1, 0.4, -0.2}};
    for (const double factor : {1.0, 50.0}) {
        ChainInput input = cell.input;
        for (std::size_t i = 0; i < input.views.size(); ++i) {
            const Rigid<frame::C, frame::C> pose{cell.poses[i].rotation, cell.poses[i].translation};
            Rigid<frame::B, frame::F> read = base * pose * mount.inverse();
            const Vec3 w = cell.draw(factor * 2.618e-5);
            read.rotation = test::turn(norm(w), w) * read.rotation;
            read.translation = read.translation + cell.draw(factor * 6.7e-6);
            input.views[i].b_from_f = read;
        }
        const ChainResult result = fit_chain(input);
        EXPECT_NEAR(result.robot_ratio / factor, 1.0, 0.35);
        EXPECT_LT(norm(result.h_from_c->translation - without.h_from_c->translation), factor > 1.0 ? 5e-6 : 60e-6);
        EXPECT_EQ(result.notes.empty(), factor == 1.0);
        ChainOptions left_out;
        left_out.robot = RobotUse::left_out;
        EXPECT_EQ(norm(fit_chain(input, left_out).h_from_c->translation - without.h_from_c->translation), 0.0);
    }
}

TEST(Chain, KnownPlacesGiveC) {
    Cell cell(8);
    cell.look_around(6);
    const ChainResult first = fit_chain(cell.input);
    Cell later(9);
    later.look(0.3, 0.0);
    later.look(-0.4, 40.0);
    later.look(0.1, 90.0);
    for (const ChainMarkerResult& m : first.markers) {
        if (!m.turns) {
            const double sigma = std::sqrt(m.covariance.at[0][0]);
            later.input.known.push_back({0, m.id, m.place, {sigma, sigma, sigma}});
        }
    }
    const ChainResult second = fit_chain(later.input);
    int compared = 0;
    for (const ChainMarkerResult& m : second.markers) {
        const ChainMarkerResult* before = first.find(m.id);  // nothing where that side was not seen
        if (before != nullptr) {
            EXPECT_LT(norm(m.place - before->place), 80e-6) << m.id;
            ++compared;
        }
    }
    EXPECT_GT(compared, 20);
    EXPECT_GT(norm(second.views[0].translation), 0.01);  // no longer the origin of c
}

TEST(Chain, WithoutPointingItIsARegistration) {
    Cell cell(10);
    cell.look_around(5);
    const ChainResult result = fit_chain(cell.input);
    EXPECT_FALSE(result.h_from_c);
    EXPECT_FALSE(result.axis_in_h);
    ASSERT_TRUE(result.axis);
    EXPECT_LT(result.axis->turn_sigma, 1e-4);
}

TEST(Chain, OneStopOfTheTableNeedsNoAxis) {
    Cell cell(11);
    for (int i = 0; i < 4; ++i) {
        cell.look(0.3 * i, 30.0);
    }
    cell.point();
    const ChainResult result = fit_chain(cell.input);
    EXPECT_FALSE(result.axis);
    EXPECT_TRUE(result.h_from_c);
    EXPECT_LT(norm(result.views[2].translation - cell.origin(2)), 60e-6);
}

TEST(Chain, StepByStepIsNearAndStatesNoCovariance) {
    Cell cell(12);
    cell.look_around(8);
    cell.point();
    ChainOptions options;
    options.predict = {{2, 90.0}};
    const ChainResult steps = chain_step_by_step(cell.input, options);
    ASSERT_EQ(steps.places.size(), 1U);
    EXPECT_LT(norm(steps.places[0].place - cell.in_h(2, -90.0)), 100e-6);
    EXPECT_EQ(steps.places[0].covariance.at[0][0], 0.0);
}

TEST(Chain, TooFewViewsAndMarkersAreNamed) {
    Cell cell(13);
    cell.look(0.0, 0.0);
    EXPECT_NE(refusal([&] { (void)fit_chain(cell.input); }).find("too few views"), std::string::npos);
    cell.look(0.2, 0.0);
    cell.input.views[1].seen.markers.resize(2);
    const std::string text = refusal([&] { (void)fit_chain(cell.input); });
    EXPECT_NE(text.find("fewer than three markers: v2: 2"), std::string::npos) << text;
}

TEST(Chain, AViewWithoutMarkersInCommonIsNamed) {
    Cell cell(14);
    cell.look_around(4);
    for (SeenMarker& m : cell.input.views[2].seen.markers) {
        m.id += 5000;
        cell.input.still.insert(m.id);
    }
    const std::string text = refusal([&] { (void)fit_chain(cell.input); });
    EXPECT_NE(text.find("0 markers in common"), std::string::npos) << text;
    EXPECT_NE(text.find("v3"), std::string::npos) << text;
    EXPECT_NE(text.find("cell.toml:4"), std::string::npos) << text;
}

TEST(Chain, MixedUnitsAndLeftHandedFramesAreNamed) {
    Cell cell(15);
    cell.look_around(4);
    ChainInput inch = cell.input;
    for (SeenMarker& m : inch.views[3].seen.markers) {
        m.place = (1.0 / 25.4) * m.place;
    }
    ChainOptions as_they_are;
    as_they_are.find_wrong = false;
    std::string text = refusal([&] { (void)fit_chain(inch, as_they_are); });
    EXPECT_NE(text.find("units differ"), std::string::npos) << text;
    EXPECT_NE(text.find("inch"), std::string::npos) << text;
    ChainInput mirrored = cell.input;
    for (SeenMarker& m : mirrored.views[3].seen.markers) {
        m.place.x = -m.place.x;
    }
    text = refusal([&] { (void)fit_chain(mirrored); });
    EXPECT_NE(text.find("left-handed"), std::string::npos) << text;
    EXPECT_NE(text.find("v4"), std::string::npos) << text;
    cell.point();
    for (SeenMarker& m : cell.input.pointing[0].markers) {
        m.place = 1000.0 * m.place;
    }
    text = refusal([&] { (void)fit_chain(cell.input); });
    EXPECT_NE(text.find("pointing.csv"), std::string::npos) << text;
    EXPECT_NE(text.find("mm for m"), std::string::npos) << text;
}

TEST(Chain, MarkersOnALineAreRefusedWithTheBlindDirection) {
    Cell cell(16);
    cell.look_around(3, 0.0);
    for (ChainView& view : cell.input.views) {
        std::erase_if(view.seen.markers, [](const SeenMarker& m) { return m.id < 100 || m.id > 102; });
        const Vec3 a = view.seen.markers[0].place;
        const Vec3 b = view.seen.markers[1].place;
        view.seen.markers[2].place = a + 2.0 * (b - a);
    }
    const std::string text = refusal([&] { (void)fit_chain(cell.input); });
    EXPECT_NE(text.find("on a line"), std::string::npos) << text;
    EXPECT_NE(text.find("its direction"), std::string::npos) << text;
}

TEST(Chain, AnAxisThatAnglesDoNotShowIsRefused) {
    Cell cell(17);
    cell.look_around(4, 0.8);
    const std::string text = refusal([&] { (void)fit_chain(cell.input); });
    EXPECT_NE(text.find("the axis is not seen"), std::string::npos) << text;
}

TEST(Chain, PlacesPointedAtOnALineAreRefused) {
    Cell cell(18);
    cell.look_around(4);
    cell.point();
    auto& markers = cell.input.pointing[0].markers;
    markers.resize(2);
    const std::string text = refusal([&] { (void)fit_chain(cell.input); });
    EXPECT_NE(text.find("fewer than three markers"), std::string::npos) << text;
    EXPECT_NE(text.find("pointing.csv"), std::string::npos) << text;
}

TEST(Chain, AnglesThatCountClockwiseAreRefused) {
    Cell cell(19);
    cell.look_around(8);
    cell.point();
    for (ChainView& view : cell.input.views) {
        view.seen.turn = -*view.seen.turn;
    }
    const std::string text = refusal([&] { (void)fit_chain(cell.input); });
    EXPECT_NE(text.find("clockwise"), std::string::npos) << text;
}

}  // namespace
}  // namespace sc::host
