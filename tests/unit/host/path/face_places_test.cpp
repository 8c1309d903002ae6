// SPDX-License-Identifier: Apache-2.0
#include "host/path/face_places.hpp"

#include <gtest/gtest.h>

#include "sample_job.hpp"

namespace sc::host {
namespace {

// With C = −90 about (−0.25, −0.47): (x, y) → (−0.25 + (y + 0.47), −0.47 − (x + 0.25)). h_from_c: (a, b, c) →
// (c − 0.5, a + 0.25, b + 0.125).
constexpr double kTolerance = 1e-12;

Job job_with_face(PlaceFrame frame, const std::filesystem::path& points) {
    Job job = sample::job();
    job.faces = {{.line = 7, .angle_deg = 90.0, .frame = frame, .points = points, .datum_line = {}}};
    return job;
}

FacePlaces places(const Job& job, bool from_table = false) {
    return face_places(job, job.faces.front(), sample::table(), sample::calibration(), reference_machine(), from_table);
}

TEST(FacePlaces, TakesTheTablesRowsOfTheFace) {
    Job job = sample::job();
    const FacePlaces found = places(job);
    ASSERT_EQ(found.markers.size(), 4U);
    EXPECT_EQ(found.markers[2].no, 3);
    EXPECT_EQ(found.markers[2].place.v, (Vec3{-0.22, sample::depth(-0.22, -0.42), -0.42}));
    EXPECT_EQ(found.markers[2].source, (Source{"sample/table.csv", 4}));
    EXPECT_FALSE(found.line);
}

TEST(FacePlaces, CarriesPointsFromCThroughTheAxis) {
    const sample::TempFile file("points.csv", "no,x,y,z\n5,-650,-500,200\n");
    const Job job = job_with_face(PlaceFrame::c, file.path());
    const FacePlaces found = places(job);
    ASSERT_EQ(found.markers.size(), 1U);
    EXPECT_EQ(found.markers[0].no, 5);
    // h at C = 0: (−0.3, −0.4, −0.375); turned: (−0.25 + 0.07, −0.47 + 0.05, −0.375).
    EXPECT_NEAR(found.markers[0].place.v.x, -0.18, kTolerance);
    EXPECT_NEAR(found.markers[0].place.v.y, -0.42, kTolerance);
    EXPECT_NEAR(found.markers[0].place.v.z, -0.375, kTolerance);
    EXPECT_EQ(found.markers[0].source, (Source{file.path(), 2}));
}

TEST(FacePlaces, CarriesPointsFromWThroughTheAlignment) {
    const sample::TempFile file("points.csv", "no,x,y,z\n1,50,20,100\n");
    Job job = job_with_face(PlaceFrame::w, file.path());
    // c = w + (−700, −520, 100) mm: the point of the test above.
    job.c_from_w = Rigid<frame::C, frame::W>{Mat3::identity(), {-0.700, -0.520, 0.100}};
    const FacePlaces found = places(job);
    EXPECT_NEAR(found.markers[0].place.v.x, -0.18, kTolerance);
    EXPECT_NEAR(found.markers[0].place.v.y, -0.42, kTolerance);
    EXPECT_NEAR(found.markers[0].place.v.z, -0.375, kTolerance);
}

TEST(FacePlaces, CarriesTheEndsOfALine) {
    Job job = sample::job();
    job.c_from_w = Rigid<frame::C, frame::W>{Mat3::identity(), {-0.700, -0.520, 0.100}};
    job.faces[1].datum_line = FaceLine{31, PlaceFrame::w, {0.05, 0.02, 0.1}, {0.05, 0.02, 0.2}};
    const FacePlaces found =
        face_places(job, job.faces[1], sample::table(), sample::calibration(), reference_machine(), false);
    ASSERT_TRUE(found.line);
    EXPECT_NEAR(found.line->from.v.x, -0.18, kTolerance);
    // 0.1 m further along w z = c z = h x at C = 0 → −y at C = −90.
    EXPECT_NEAR(found.line->to.v.x, -0.18, kTolerance);
    EXPECT_NEAR(found.line->to.v.y, -0.52, kTolerance);
    EXPECT_EQ(found.line->source, (Source{"sample/job.toml", 31}));
}

TEST(FacePlaces, AnotherTableTakesThePlaceOfAPointsFile) {
    const Job job = job_with_face(PlaceFrame::c, "not/there.csv");
    const FacePlaces found = places(job, true);
    ASSERT_EQ(found.markers.size(), 4U);
    EXPECT_NEAR(norm(found.markers[1].place.v - sample::table().rows[5].measured.v), 0.0, kTolerance);
    EXPECT_EQ(found.markers[1].source, (Source{"sample/table.csv", 7}));
}

TEST(FacePlaces, AnotherTableNeedsTheChainAllTheSame) {
    const Job job = job_with_face(PlaceFrame::c, "not/there.csv");
    CalibrationSet set = sample::calibration();
    set.transforms.clear();
    EXPECT_THROW((void)face_places(job, job.faces.front(), sample::table(), set, reference_machine(), true),
                 InputError);
}

TEST(FacePlaces, RefusesPointsInMetres) {
    const sample::TempFile file("points.csv", "no,x,y,z\n1,-0.650,-0.500,0.160\n2,-0.640,-0.500,0.160\n");
    const Job job = job_with_face(PlaceFrame::c, file.path());
    const InputError error = sample::refusal_of([&] { (void)places(job); });
    EXPECT_EQ(error.file(), file.path().string());
    EXPECT_EQ(error.line(), 2);
    EXPECT_NE(error.problem().find("metres"), std::string::npos) << error.what();
    EXPECT_EQ(error.value(), "-0.65");
}

TEST(FacePlaces, RefusesAFaceWithoutPoints) {
    Job job = sample::job();
    job.faces[0].angle_deg = 45.0;
    const InputError error = sample::refusal_of([&] { (void)places(job); });
    EXPECT_EQ(error.file(), "sample/job.toml");
    EXPECT_EQ(error.line(), 20);
    EXPECT_EQ(error.value(), "45");
}

TEST(FacePlaces, RefusesWWithoutAlignment) {
    const sample::TempFile file("points.csv", "no,x,y,z\n1,50,20,100\n");
    const Job job = job_with_face(PlaceFrame::w, file.path());
    EXPECT_THROW((void)places(job), InputError);
}

TEST(SameFace, ToleratesRoundingOnly) {
    EXPECT_TRUE(same_face(90.0, 90.0 + 1e-9));
    EXPECT_FALSE(same_face(90.0, 90.001));
    EXPECT_FALSE(same_face(0.0, 360.0));
}

}  // namespace
}  // namespace sc::host
