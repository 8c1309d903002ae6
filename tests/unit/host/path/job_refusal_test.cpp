// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "host/path/job_plan.hpp"
#include "sample_job.hpp"

/// What the machine cannot do is refused before anything moves, with file, line, value and what to do.

namespace sc::host {
namespace {

using namespace literals;

InputError refused(const Job& job, const VerificationTable& table = sample::table(),
                   const MachineConfig& machine = reference_machine(), const PlanOptions& options = {}) {
    return sample::refusal_of([&] { (void)plan_job(job, table, sample::calibration(), machine, options); });
}

void expect_at_marker(const InputError& error, int line, std::string_view value) {
    EXPECT_EQ(error.file(), "sample/table.csv") << error.what();
    EXPECT_EQ(error.line(), line) << error.what();
    EXPECT_EQ(error.value(), value) << error.what();
    EXPECT_FALSE(error.action().empty());
}
void expect_in_job(const InputError& error, std::string_view value) {
    EXPECT_EQ(error.file(), "sample/job.toml") << error.what();
    EXPECT_EQ(error.value(), value) << error.what();
    EXPECT_FALSE(error.action().empty());
}

TEST(JobRefusal, PointOutOfTravelOnEachAxisAndSide) {
    struct Case {
        Vec3 place;
        const char* value;
    };
    for (const Case& c : {Case{{-0.4501, -0.3, -0.4}, "-450.100 mm"}, Case{{0.0051, -0.3, -0.4}, "5.100 mm"},
                          Case{{-0.2, -0.4001, -0.4}, "-400.100 mm"}, Case{{-0.2, 0.0051, -0.4}, "5.100 mm"},
                          Case{{-0.2, -0.3, -0.5001}, "-500.100 mm"}, Case{{-0.2, -0.3, 0.0051}, "5.100 mm"}}) {
        VerificationTable table = sample::table();
        table.rows[2].measured.v = c.place;
        expect_at_marker(refused(sample::job(), table), 4, c.value);
    }
}

TEST(JobRefusal, PointAtTheEdgeOfTravelIsFineForTheGalvoButNotForTheAxes) {
    VerificationTable table = sample::table();
    table.rows[0].measured.v.x = -0.4499;
    Job job = sample::job();
    job.datum_line.reset();
    EXPECT_NO_THROW((void)sample::plan(job, table));
    job.cross->settings = sample::axes_settings();
    const InputError error = refused(job, table);
    EXPECT_EQ(error.line(), 2);
    EXPECT_NE(error.problem().find("travel"), std::string::npos);
}

TEST(JobRefusal, PulseWidthsThatDiffer) {
    Job job = sample::job();
    job.cross->settings.pulse_width_ns = 20;
    expect_in_job(refused(job), "20 and 0 ns");
    job.datum_line->settings.pulse_width_ns = 20;
    EXPECT_EQ(sample::plan(job, sample::table()).pulse_width_ns, 20);
    EXPECT_EQ(sample::plan(sample::job(), sample::table()).pulse_width_ns, 0);
}

TEST(JobRefusal, RunInOutOfTravel) {
    // The stroke ends 0.5 mm before the end of travel: its run-in needs more.
    VerificationTable table = sample::table();
    table.rows[0].measured.v.x = -0.4475;
    Job job = sample::job();
    job.datum_line.reset();
    job.cross->settings = sample::axes_settings();
    const InputError error = refused(job, table);
    EXPECT_EQ(error.line(), 2);
    EXPECT_NE(error.problem().find("run-"), std::string::npos) << error.what();
}

TEST(JobRefusal, CompensationThatMovesASetPointOutOfTravel) {
    VerificationTable table = sample::table();
    table.rows[0].measured.v.x = -0.44999;
    Job job = sample::job();
    job.datum_line.reset();
    CalibrationSet set = sample::calibration();
    AxesRecord axes;
    axes.squareness_xz = -1e-4;  // 42 µm at z = −0.42
    set.axes = axes;
    const InputError error = sample::refusal_of([&] { (void)plan_job(job, table, set, reference_machine()); });
    EXPECT_EQ(error.line(), 2);
    set.axes->squareness_xz = 1e-4;
    EXPECT_NO_THROW((void)plan_job(job, table, set, reference_machine()));
}

TEST(JobRefusal, PointInAKeepOutVolume) {
    VerificationTable table = sample::table();
    table.rows[5].measured.v = {-0.22, -0.3, -0.49};
    expect_at_marker(refused(sample::job(), table), 7, "(-220.000, -300.000, -490.000) mm");
}

TEST(JobRefusal, StrokeThatReachesIntoAKeepOutVolume) {
    VerificationTable table = sample::table();
    table.rows[5].measured.v.z = -0.4785;  // 1.5 mm above it; the stroke goes 2 mm down
    EXPECT_EQ(refused(sample::job(), table).line(), 7);
    table.rows[5].measured.v.z = -0.4770;
    EXPECT_NO_THROW((void)sample::plan(sample::job(), table));
}

TEST(JobRefusal, FaceThatTheTurntableCannotReach) {
    MachineConfig machine = reference_machine();
    machine.axis[index(Axis::c)].travel_min = -45.0;
    machine.axis[index(Axis::c)].travel_max = 45.0;
    const InputError error = refused(sample::job(), sample::table(), machine);
    expect_in_job(error, "90");
    EXPECT_EQ(error.line(), 25);
}

TEST(JobRefusal, FaceThatTheJobDoesNotHave) {
    const InputError error = refused(sample::job(), sample::table(), reference_machine(), {.face = 45.0});
    expect_in_job(error, "45");
    EXPECT_NE(error.action().find("0, 90"), std::string::npos);
}

TEST(JobRefusal, CrossLargerThanTheField) {
    Job job = sample::job();
    job.cross->size = 109.9_mm;
    EXPECT_EQ(refused(job).file(), "sample/table.csv");
    EXPECT_EQ(refused(job).line(), 5);  // marker 4, nearest to home, comes first
    EXPECT_NE(refused(job).problem().find("field"), std::string::npos);
    job.cross->size = 109.0_mm;
    EXPECT_NO_THROW((void)sample::plan(job, sample::table()));
}

TEST(JobRefusal, SpeedAboveTheActuators) {
    Job job = sample::job();
    job.cross->settings.speed = 2001_mm_s;
    job.cross->settings.pitch = 100_um;
    expect_in_job(refused(job), "2001 mm/s");
    job = sample::job();
    job.datum_line->settings.speed = 201_mm_s;
    expect_in_job(refused(job), "201 mm/s");
}

TEST(JobRefusal, SpeedBelowTheLasersLeast) {
    Job job = sample::job();
    job.datum_line->settings.speed = 1.9_mm_s;
    expect_in_job(refused(job), "1.9 mm/s");
}

TEST(JobRefusal, PulseRateThatTheLaserCannotMake) {
    Job job = sample::job();
    job.cross->settings.pitch = 3_um;  // 83.3 kHz
    EXPECT_NE(refused(job).problem().find("pulse rate"), std::string::npos);
    job = sample::job();
    job.datum_line->settings.speed = 2_mm_s;
    job.datum_line->settings.pitch = 50_um;  // 40 Hz: 500 periods of 20 kHz
    expect_in_job(refused(job), "40 Hz");
}

TEST(JobRefusal, PulseRateBetweenTheMultiplesOfANarrowRange) {
    MachineConfig machine = reference_machine();
    machine.laser.prr_min = 70_kHz;  // 12.5 kHz: 62.5 or 75
    Job job = sample::job();
    job.datum_line.reset();
    EXPECT_NO_THROW((void)plan_job(job, sample::table(), sample::calibration(), machine));
    machine.laser.prr_min = 76_kHz;
    expect_in_job(refused(job, sample::table(), machine), "12500 Hz");
}

TEST(JobRefusal, EnergyAboveThePowersShare) {
    Job job = sample::job();
    job.cross->settings.energy = 3201.0_uJ;  // 80 W / 25 kHz = 3200 µJ
    expect_in_job(refused(job), "3201 uJ");
    job.cross->settings.energy = 3200.0_uJ;
    EXPECT_NO_THROW((void)sample::plan(job, sample::table()));
}

TEST(JobRefusal, EnergyBelowOneStepOfPower) {
    Job job = sample::job();
    job.cross->settings.energy = 6.0_uJ;  // a step is 3200 / 255 = 12.5 µJ
    expect_in_job(refused(job), "6 uJ");
}

TEST(JobRefusal, DatumLineUnder60Millimetres) {
    Job job = sample::job();
    job.datum_line->length = 59_mm;
    EXPECT_NE(refused(job).problem().find("short"), std::string::npos);
    job = sample::job();
    job.faces[0].datum_line = FaceLine{22, PlaceFrame::h, {-0.25, -0.3, -0.4}, {-0.2, -0.3, -0.4}};
    const InputError error = refused(job);
    expect_in_job(error, "50.000 mm");
    EXPECT_EQ(error.line(), 22);
}

TEST(JobRefusal, DatumLineLongerThanTravel) {
    Job job = sample::job();
    job.datum_line->length = 455_mm;
    expect_in_job(refused(job), "455 mm");
}

TEST(JobRefusal, StrokeOfNoLength) {
    Job job = sample::job();
    job.cross->size = Length{};
    EXPECT_NE(refused(job).problem().find("shorter"), std::string::npos);
}

TEST(JobRefusal, FaceOnWhichNothingIsBurnt) {
    Job job = sample::job();
    job.cross.reset();
    job.datum_line.reset();
    const InputError error = refused(job);
    EXPECT_EQ(error.line(), 20);
}

TEST(JobRefusal, LineEndsWithoutSettings) {
    Job job = sample::job();
    job.datum_line.reset();
    job.faces[0].datum_line = FaceLine{22, PlaceFrame::h, {-0.25, -0.3, -0.4}, {-0.15, -0.3, -0.4}};
    EXPECT_EQ(refused(job).line(), 22);
}

}  // namespace
}  // namespace sc::host
