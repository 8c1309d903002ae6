// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/resume.hpp"

#include <gtest/gtest.h>

#include "host/formats/error.hpp"
#include "shared/path/job_hash.hpp"

namespace sc::host {
namespace {

/// Turn, path 1 (items 1 to 5), turn, path 2 pass 0 (7 to 10), path 2 pass 1 (11 to 14), end.
std::vector<Item> job() {
    const PathBegin one{.path = 1, .pitch_nm = 20'000};
    const PathBegin two{.path = 2, .pitch_nm = 20'000};
    PathBegin again = two;
    again.pass = 1;
    return {Turn{100},   one,          PathPoint{}, PathPoint{1}, PathPoint{2}, PathEnd{},    Turn{-900}, two,
            PathPoint{}, PathPoint{5}, PathEnd{},   again,        PathPoint{},  PathPoint{5}, PathEnd{},  JobEnd{}};
}

TEST(ResumePoint, InAPathGoesBackToItsBeginAndKeepsItsPulses) {
    const auto items = job();
    const ResumePoint point = resume_point(items, {.fired = 3, .path = 1, .pass = 0, .pulses = 12});
    EXPECT_EQ(point.first, 1U);
    EXPECT_EQ(point.pulses, 12U);
    EXPECT_EQ(point.c, 100);
    EXPECT_EQ(point.hash_before, job_hash(std::span(items).first(1)));
}

TEST(ResumePoint, BehindAPathBeginsTheNext) {
    const ResumePoint point = resume_point(job(), {.fired = 6, .path = 1, .pass = 0, .pulses = 40});
    EXPECT_EQ(point.first, 6U);
    EXPECT_EQ(point.pulses, 0U);
    EXPECT_EQ(point.c, -900);
    EXPECT_EQ(resume_point(job(), {.fired = 15, .path = 2, .pass = 1, .pulses = 9}).first, 15U);
    EXPECT_EQ(resume_point(job(), {}).first, 0U);
    EXPECT_EQ(resume_point(job(), {.fired = 9, .path = 2}).first, 7U) << "in a path, before its first pulse";
}

TEST(ResumePoint, TellsThePassesOfAPathApart) {
    EXPECT_EQ(resume_point(job(), {.fired = 12, .path = 2, .pass = 1, .pulses = 3}).first, 11U);
    EXPECT_EQ(resume_point(job(), {.fired = 8, .path = 2, .pass = 0, .pulses = 3}).first, 7U);
}

TEST(ResumePoint, RefusesAPlaceOfAnotherJob) {
    EXPECT_THROW((void)resume_point(job(), {.fired = 3}), InputError);
    EXPECT_THROW((void)resume_point(job(), {.fired = 99, .path = 1, .pulses = 1}), InputError);
}

/// Turn, two looks (1, 2), path 1 (3 to 6), path 2 (7 to 10), two looks (11, 12), path 3 (13 to 16), end.
std::vector<Item> watched_job() {
    std::vector<Item> items{Turn{100}};
    const auto looks = [&] { items.insert(items.end(), {Look{0, 1, 2, 3}, Look{50'000, 9, 2, 3}}); };
    const auto path = [&](std::uint32_t id) {
        items.insert(items.end(), {PathBegin{.path = id, .pitch_nm = 20'000}, PathPoint{}, PathPoint{5}, PathEnd{}});
    };
    looks();
    path(1);
    path(2);
    looks();
    path(3);
    items.emplace_back(JobEnd{});
    return items;
}

TEST(ResumePoint, WhereTheSurfaceIsWatchedItIsLookedAtAgainFirst) {
    const auto items = watched_job();
    struct Case {
        FiredPlace place;
        std::uint32_t first;
        std::uint32_t path;
        std::uint32_t pulses;
    };
    const std::vector<Case> cases{
        {{.fired = 1}, 1, 1, 0},                             // before the first look
        {{.fired = 2}, 1, 1, 0},                             // in the midst of looks
        {{.fired = 4, .path = 1, .pulses = 7}, 1, 1, 7},     // on the first path
        {{.fired = 7, .path = 1, .pulses = 40}, 1, 2, 0},    // between the paths
        {{.fired = 8, .path = 2, .pulses = 3}, 1, 2, 3},     // on the second
        {{.fired = 11, .path = 2, .pulses = 40}, 11, 3, 0},  // before the looks of the next group
        {{.fired = 12, .path = 2, .pulses = 40}, 11, 3, 0},  // in the midst of them
        {{.fired = 17, .path = 3, .pulses = 40}, 17, 0, 0},  // all is burnt
        {{.fired = 1, .path = 2, .pulses = 3}, 1, 2, 3},     // broken off again while it looked anew
        {{.fired = 5, .path = 2, .pulses = 3}, 1, 2, 3},     // and while a path was passed over
        {{.fired = 2, .path = 2, .pulses = 0}, 1, 2, 0},     // the path to come had nothing burnt yet
        {{.fired = 5, .path = 2, .pulses = 0}, 1, 2, 0},
    };
    for (const Case& c : cases) {
        const ResumePoint point = resume_point(items, c.place);
        EXPECT_EQ(point.first, c.first) << c.place.fired << ' ' << c.place.path;
        EXPECT_EQ(point.pulses, c.pulses) << c.place.fired << ' ' << c.place.path;
        EXPECT_EQ(point.path, c.path) << c.place.fired << ' ' << c.place.path;
        EXPECT_EQ(point.hash_before, job_hash(std::span(items).first(c.first)));
    }
}

TEST(ConfirmedPlace, PathsOfOneLookAreStillInTheirOrder) {
    const auto items = watched_job();
    const KnownPlace known{.source = PlaceSource::retained, .certain = {7, 1, 0, 40}, .reached = {8, 2, 0, 5}};
    EXPECT_EQ(confirmed_place(items, known, "2/0/4").pulses, 4U);
    EXPECT_THROW((void)confirmed_place(items, known, "1/0/4"), InputError);
    EXPECT_THROW((void)confirmed_place(items, known, "2/0/6"), InputError);
}

TEST(KnownPlace, PrefersTheControllersWordAndFallsBackOnWhatWasSent) {
    link::Position told;
    told.source = 1;
    told.job = 7;
    told.items = 16;
    told.fired = 3;
    told.path = told.reached_path = 1;
    told.pulses = told.reached_pulses = 12;
    const JobProgress last{.sent = 9, .fired = 2, .path = 1, .pulses = 5};
    EXPECT_TRUE(known_place(told, last, 7, 16).exact());
    EXPECT_EQ(known_place(told, last, 7, 16).certain.pulses, 12U);
    const KnownPlace other = known_place(told, last, 8, 16);
    EXPECT_EQ(other.source, PlaceSource::journal);
    EXPECT_FALSE(other.exact());
    EXPECT_EQ(other.reached.fired, 9U);
    EXPECT_TRUE(known_place(std::nullopt, std::nullopt, 7, 16).exact()) << "nothing was sent: from the beginning";
}

TEST(ConfirmedPlace, TakesWhatAPersonFoundWithinTheStretchAlone) {
    const auto items = job();
    KnownPlace known{.source = PlaceSource::retained, .certain = {3, 1, 0, 12}, .reached = {3, 1, 0, 17}};
    EXPECT_EQ(describe_uncertain(items, known), "pulses 12 to 16 of path 1, pass 0 (0.100 mm)");
    EXPECT_EQ(confirmed_place(items, known, "burnt").pulses, 17U);
    EXPECT_EQ(confirmed_place(items, known, "unburnt").pulses, 12U);
    EXPECT_EQ(confirmed_place(items, known, "1/0/14").pulses, 14U);
    for (const char* wrong : {"1/0/18", "1/0/11", "2/0/1", "9/0/1", "perhaps", "1/0", "1/0/14x", ""}) {
        EXPECT_THROW((void)confirmed_place(items, known, wrong), InputError) << wrong;
    }
    known.source = PlaceSource::journal;
    known.reached = {9, 1, 0, 0xFFFFFFFF};
    EXPECT_THROW((void)confirmed_place(items, known, "burnt"), InputError);
    EXPECT_EQ(confirmed_place(items, known, "2/0/1").pulses, 1U);
    EXPECT_THROW((void)confirmed_place(items, known, "2/1/1"), InputError);
}

}  // namespace
}  // namespace sc::host
