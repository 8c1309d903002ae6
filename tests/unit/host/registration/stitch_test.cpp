// SPDX-License-Identifier: Apache-2.0
#include "host/registration/stitch.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/formats/error.hpp"
#include "tests/unit/host/registration/cell.hpp"

namespace sc::host {
namespace {

namespace fs = std::filesystem;
using test::Cell;
using test::kDegree;

ScanSet set_of(const Cell& cell) {
    ScanSet set;
    set.file = "scan.toml";
    set.id = "scan";
    set.time = "2026-01-31T12:00:00Z";
    for (const ChainView& view : cell.input.views) {
        ScanView out;
        out.line = view.seen.line;
        out.id = view.seen.view;
        out.c_deg = *view.seen.turn / kDegree;
        for (const SeenMarker& m : view.seen.markers) {
            out.markers.push_back({m.id, m.place, m.sigma.x});
        }
        set.views.push_back(out);
    }
    return set;
}

Target ring_of(const Cell& cell, double sigma) {
    Target target;
    target.id = "ring";
    for (const int id : cell.input.still) {
        target.markers.push_back({id, {0.001 * id, 0.0, 0.0}, sigma});
    }
    return target;
}

std::string refusal(const ScanSet& set, const ScanTargets& targets) {
    try {
        (void)chain_input(set, targets);
    } catch (const InputError& error) {
        return error.what();
    }
    return "nothing was refused";
}

TEST(Stitch, MarkersOfTargetsStandStillAndMeasuredPlacesAreKnown) {
    Cell cell(1);
    cell.look_around(3);
    const ScanSet set = set_of(cell);
    const ChainInput nominal = chain_input(set, {.targets = {ring_of(cell, 0.0)}, .still = {77}});
    EXPECT_EQ(nominal.still.size(), cell.input.still.size() + 1);
    EXPECT_TRUE(nominal.still.contains(77));
    EXPECT_TRUE(nominal.known.empty());
    ASSERT_EQ(nominal.views.size(), 3U);
    EXPECT_NEAR(*nominal.views[1].seen.turn, *cell.input.views[1].seen.turn, 1e-12);
    EXPECT_EQ(chain_input(set, {.targets = {ring_of(cell, 5e-6)}, .still = {}}).known.size(), cell.input.still.size());
    Target mobile = ring_of(cell, 5e-6);
    mobile.kind = TargetKind::mobile;  // certified, but nobody knows where it stands
    EXPECT_TRUE(chain_input(set, {.targets = {mobile}, .still = {}}).known.empty());
}

TEST(Stitch, MismatchedTargetsAndViewsAreNamed) {
    Cell cell(2);
    cell.look_around(2);
    ScanSet set = set_of(cell);
    Target other = ring_of(cell, 0.0);
    other.id = "other";
    EXPECT_NE(refusal(set, {.targets = {ring_of(cell, 0.0), other}, .still = {}}).find("same id (ring, other)"),
              std::string::npos);
    Target measured = ring_of(cell, 5e-6);
    measured.id = "second";
    for (TargetMarker& m : measured.markers) {
        m.id += 2000;
    }
    EXPECT_NE(refusal(set, {.targets = {ring_of(cell, 5e-6), measured}, .still = {}}).find("two fixed targets"),
              std::string::npos);
    set.views[1].markers.clear();
    set.views[1].cloud = "cloud.ply";
    const std::string text = refusal(set, {.targets = {}, .still = {}});
    EXPECT_NE(text.find("no markers"), std::string::npos) << text;
    EXPECT_NE(text.find("v2"), std::string::npos) << text;
}

TEST(Stitch, NumbersThatMeanNothingAreFoundByDistances) {
    Cell cell(3);
    for (int i = 0; i < 4; ++i) {
        cell.look(0.25 * i - 0.4, 0.0);
    }
    const ScanSet truth = set_of(cell);
    ScanSet set = truth;
    for (std::size_t v = 0; v < set.views.size(); ++v) {
        for (std::size_t k = 0; k < set.views[v].markers.size(); ++k) {
            set.views[v].markers[k].id = static_cast<int>((7 * k + 3 * v) % set.views[v].markers.size());
        }
    }
    const ChainInput input = chain_input(set, {.targets = {}, .still = {}, .ids_unknown = true});
    std::map<int, int> meaning;
    for (std::size_t v = 0; v < set.views.size(); ++v) {
        for (std::size_t k = 0; k < set.views[v].markers.size(); ++k) {
            const int named = input.views[v].seen.markers[k].id;
            const auto [at, added] = meaning.try_emplace(named, truth.views[v].markers[k].id);
            EXPECT_EQ(at->second, truth.views[v].markers[k].id) << named;
        }
    }
    const ChainResult result = fit_chain(input);
    EXPECT_LT(norm(result.views[3].translation - cell.origin(3)), 60e-6);
    for (ScanMarker& m : set.views[2].markers) {
        m.place = m.place + cell.draw(0.05);
    }
    const std::string text = refusal(set, {.targets = {}, .still = {}, .ids_unknown = true});
    EXPECT_NE(text.find("match nothing"), std::string::npos) << text;
    EXPECT_NE(text.find("v3"), std::string::npos) << text;
}

TEST(Stitch, CloudsOfAllViewsComeTogetherAtCZero) {
    Cell cell(5);
    cell.look_around(8);
    ScanSet set = set_of(cell);
    const fs::path folder = fs::path(::testing::TempDir()) / ("scribecell_stitch_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    const Vec3 spot{0.08, -0.05, 0.12};  // on the table
    for (std::size_t v = 0; v < set.views.size(); ++v) {
        const Vec3 now = cell.axis_at + test::turn(set.views[v].c_deg * kDegree, cell.axis) * (spot - cell.axis_at);
        const Vec3 seen = (cell.poses[v].inverse() * Point<frame::C>{now}).v;
        set.views[v].cloud = folder / (set.views[v].id + ".xyz");
        std::ofstream out(set.views[v].cloud);
        out.precision(12);
        out << 1e3 * seen.x << " " << 1e3 * seen.y << " " << 1e3 * seen.z << "\n";
    }
    const ChainResult chain = fit_chain(chain_input(set, {.targets = {ring_of(cell, 0.0)}, .still = {}}));
    const PointCloud cloud = stitch_clouds(set, chain);
    fs::remove_all(folder);
    ASSERT_EQ(cloud.points.size(), 8U);
    const Vec3 expected = (cell.poses[0].inverse() * Point<frame::C>{spot}).v;
    for (std::size_t i = 0; i < 8; ++i) {
        EXPECT_LT(norm(cloud.points[i] - expected), 60e-6) << i;
        EXPECT_EQ(cloud.view[i], i);
    }
}

TEST(Stitch, TheMapOfMarkersHasWhatStandsStill) {
    Cell cell(6);
    cell.look_around(4);
    const ChainResult chain = fit_chain(cell.input);
    const Target map = marker_map(chain, "map");
    EXPECT_EQ(map.kind, TargetKind::fixed);
    for (const TargetMarker& m : map.markers) {
        EXPECT_TRUE(cell.input.still.contains(m.id));
        EXPECT_GT(m.sigma, 0.0);
        EXPECT_LT(m.sigma, 50e-6);
    }
    EXPECT_GT(map.markers.size(), 15U);
}

}  // namespace
}  // namespace sc::host
