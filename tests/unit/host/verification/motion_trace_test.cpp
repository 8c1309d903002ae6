// SPDX-License-Identifier: Apache-2.0
#include "host/verification/motion_trace.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/formats/error.hpp"
#include "shared/codes/state.hpp"
#include "shared/trace/trace.hpp"

namespace sc::host {
namespace {

namespace fs = std::filesystem;

class MotionTraceFile : public ::testing::Test {
protected:
    void SetUp() override {
        const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
        folder_ = fs::path(::testing::TempDir()) / ("motion_trace_" + name + std::to_string(::getpid()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    [[nodiscard]] fs::path write(const std::string& text) const {
        std::ofstream(folder_ / "trace", std::ios::binary) << text;
        return folder_ / "trace";
    }
    void expect_refused(const std::string& text, int line, const std::string& part, const std::string& value) const {
        const fs::path file = write(text);
        try {
            (void)read_motion_trace(file);
            FAIL() << "taken: " << text;
        } catch (const InputError& error) {
            EXPECT_EQ(error.file(), file.string());
            EXPECT_EQ(error.line(), line) << error.what();
            EXPECT_EQ(error.value(), value) << error.what();
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
            EXPECT_FALSE(error.action().empty());
        }
    }

    fs::path folder_;
};

TEST_F(MotionTraceFile, ReadsSecondsAndMetres) {
    const MotionTrace trace = read_motion_trace(
        write("t_s,x_m,y_m,z_m\n0.500,0.1,-0.2,1e-12\n0.501,0.100000000001,-0.2,0\n0.502,0.1,-0.2,0.0000000000004\n"));
    ASSERT_EQ(trace.samples.size(), 3U);
    EXPECT_EQ(trace.first_tick, 500);
    EXPECT_EQ(trace.samples[0], (AxisPositions{100'000'000'000, -200'000'000'000, 1, 0}));
    EXPECT_EQ(trace.samples[1][0], 100'000'000'001);
    EXPECT_EQ(trace.samples[2][2], 0);
    EXPECT_FALSE(trace.has_c);
    EXPECT_FALSE(trace.machine);
    EXPECT_EQ(trace.led, (std::vector<std::uint8_t>{1, 1, 1}));
}

TEST_F(MotionTraceFile, ReadsTicksAndPicometresInAnyOrderOfColumns) {
    const MotionTrace trace = read_motion_trace(
        write("c_ndeg,tick,z_pm,y_pm,x_pm\n-90000000001,7,3,2,1\n# later\n5,8,-3,-2,999999999999999\n"));
    ASSERT_EQ(trace.samples.size(), 2U);
    EXPECT_EQ(trace.first_tick, 7);
    EXPECT_EQ(trace.samples[0], (AxisPositions{1, 2, 3, -90'000'000'001}));
    EXPECT_EQ(trace.samples[1], (AxisPositions{999'999'999'999'999, -2, -3, 5}));
    EXPECT_TRUE(trace.has_c);
}

TEST_F(MotionTraceFile, RefusesWhatIsNoMotion) {
    const std::string head = "t_s,x_m,y_m,z_m\n";
    expect_refused("", 0, "is empty", "");
    expect_refused(head, 0, "too few samples", "0");
    expect_refused(head + "0,0,0,0\n", 0, "too few samples", "1");
    expect_refused("t_s,x_m,y_m\n0,0,0\n", 1, "missing", "z_m");
    expect_refused("t_s,x_m,y_m,z_m,b_deg\n0,0,0,0,0\n", 1, "unknown column", "b_deg");
    expect_refused("tick,x_m,y_m,z_m\n0,0,0,0\n", 1, "unknown column", "x_m");
    expect_refused(head + "0,0,0,0\n0.001,0,0\n", 3, "3 fields", "0.001,0,0");
    expect_refused(head + "0,0,0,0\n0.001,nan,0,0\n", 3, "x_m is not a finite number", "nan");
    expect_refused(head + "0,0,0,0\n0.001,0,inf,0\n", 3, "y_m is not a finite number", "inf");
    expect_refused(head + "0,0,0,0\n0.001,0,0,zero\n", 3, "z_m is not a number", "zero");
    expect_refused(head + "0,0,0,0\n0.001,0,0,1000.5\n", 3, "beyond 1000 m", "1000.5");
    expect_refused("tick,x_pm,y_pm,z_pm\n0,0,0,0\n1,0,0.5,0\n", 3, "y_pm is not a whole number", "0.5");
    expect_refused("tick,x_pm,y_pm,z_pm\n0,0,0,0\n1.5,0,0,0\n", 3, "tick is not a whole number", "1.5");
}

TEST_F(MotionTraceFile, RefusesGapsAndOtherRates) {
    const std::string head = "t_s,x_m,y_m,z_m\n0,0,0,0\n0.001,0,0,0\n";
    expect_refused(head + "0.003,0,0,0\n", 4, "gap of 1 missing", "0.003");
    expect_refused(head + "0.002,0,0,0\n0.012,0,0,0\n", 5, "gap of 9 missing", "0.012");
    expect_refused(head + "0.001,0,0,0\n", 4, "not one tick", "0.001");
    expect_refused(head + "0.0005,0,0,0\n", 4, "not one tick", "0.0005");
    expect_refused("t_s,x_m,y_m,z_m\n0,0,0,0\n0.002,0,0,0\n0.004,0,0,0\n", 3, "gap of 1 missing", "0.002");
    expect_refused("tick,x_pm,y_pm,z_pm\n5,0,0,0\n6,0,0,0\n8,0,0,0\n", 4, "gap of 1 missing", "8");
    expect_refused("tick,x_pm,y_pm,z_pm\n5,0,0,0\n4,0,0,0\n", 3, "not one tick", "4");
    // A clock that is slow by less than a microsecond a tick.
    std::string slow = "t_s,x_m,y_m,z_m\n";
    for (int n = 0; n < 5; ++n) {
        slow += std::to_string(0.0010008 * n) + "00,0,0,0\n";
    }
    EXPECT_THROW((void)read_motion_trace(write(slow)), InputError);
}

TEST_F(MotionTraceFile, RefusesAMissingFile) {
    EXPECT_THROW((void)read_motion_trace(folder_ / "none.csv"), InputError);
    EXPECT_THROW((void)read_motion_trace(folder_), InputError);
    EXPECT_FALSE(is_sample_trace(folder_ / "none.csv"));
}

constexpr const char* kMachine =
    R"({"axis":[{"travel_min":-1,"travel_max":1,"speed":0.2,"acceleration":5,"jerk":200},)"
    R"({"travel_min":-1,"travel_max":1,"speed":0.3,"acceleration":5,"jerk":200},)"
    R"({"travel_min":-1,"travel_max":1,"speed":0.2,"acceleration":5,"jerk":200},)"
    R"({"travel_min":-9,"travel_max":9,"speed":45,"acceleration":180,"jerk":1800,"following_window":0.5}],)"
    R"("galvo":{"half_field":0.02,"speed":2,"acceleration":8000,"jerk":8e7},"galvo_period_ns":10000,)"
    R"("y_retracted":-0.2,"keep_out":[{"min_m":[0,0,0],"max_m":[1,2,3]}]})";

std::string cell_trace(const std::string& machine, const std::vector<std::int64_t>& ticks) {
    const std::string header = R"({"control_period_ns":1000000,"machine":)" + machine + "}";
    std::string text(trace::kSampleMagic.begin(), trace::kSampleMagic.end());
    for (unsigned i = 0; i < 4; ++i) {
        text += static_cast<char>((header.size() >> (8U * i)) & 0xffU);
    }
    text += header;
    for (const std::int64_t tick : ticks) {
        trace::SampleRecord record;
        record.tick = tick;
        record.set_point = {tick, 2, 3, 4};
        record.state = static_cast<std::uint8_t>(tick % 2 == 0 ? State::idle : State::homing);
        std::array<std::uint8_t, trace::kSampleRecordSize> bytes{};
        trace::pack(record, bytes);
        text.append(bytes.begin(), bytes.end());
    }
    return text;
}

TEST_F(MotionTraceFile, ReadsACellsTraceAndItsMachine) {
    const MotionTrace trace = read_motion_trace(write(cell_trace(kMachine, {4, 5, 6})));
    ASSERT_TRUE(trace.machine);
    EXPECT_EQ(trace.first_tick, 4);
    EXPECT_EQ(trace.samples.size(), 3U);
    EXPECT_EQ(trace.samples[2], (AxisPositions{6, 2, 3, 4}));
    EXPECT_EQ(trace.led, (std::vector<std::uint8_t>{1, 0, 1}));
    EXPECT_EQ(trace.machine->axis[1].speed, 0.3);
    EXPECT_EQ(trace.machine->axis[3].following_window, 0.5);
    EXPECT_GT(trace.machine->axis[0].following_window, 1e9) << "not known, not judged";
    EXPECT_EQ(trace.machine->keep_out_count, 1);
    EXPECT_EQ(trace.machine->keep_out[0].max.z, 3.0);
    EXPECT_EQ(trace.machine->galvo.speed.si(), 2.0);
    EXPECT_EQ(trace.machine->y_retracted.si(), -0.2);
}

TEST_F(MotionTraceFile, RefusesACellsTraceThatCannotBeJudged) {
    expect_refused(cell_trace(kMachine, {}), 0, "no samples", "");
    expect_refused(cell_trace(kMachine, {4, 5, 7}), 0, "no tick 6", "7");
    const std::string whole = cell_trace(kMachine, {4, 5});
    expect_refused(whole.substr(0, whole.size() - 10), 0, "ends within",
                   "byte offset " + std::to_string(whole.size() - trace::kSampleRecordSize));
    const std::string none = R"({"axis":[]})";
    EXPECT_THROW((void)read_motion_trace(write(cell_trace(none, {1, 2}))), InputError);
    std::string zero(kMachine);
    zero.replace(zero.find("\"jerk\":200"), 10, "\"jerk\":0.0");
    EXPECT_THROW((void)read_motion_trace(write(cell_trace(zero, {1, 2}))), InputError);
}

TEST_F(MotionTraceFile, ReadsAPolylineInMillimetres) {
    const std::vector<Vec3> path = read_polyline(write("x,y,z\n1.5,0,-2000\n0.0001,0,0\n"));
    ASSERT_EQ(path.size(), 2U);
    EXPECT_EQ(path[0], (Vec3{0.0015, 0.0, -2.0}));
    EXPECT_NEAR(path[1].x, 1e-7, 1e-20);
    EXPECT_THROW((void)read_polyline(write("x,y,z\n0,0,0\n")), InputError);
    EXPECT_THROW((void)read_polyline(write("x,y,z\n0,0,0\n0,nan,0\n")), InputError);
    EXPECT_THROW((void)read_polyline(write("x,y,z\n0,0,0\n0,1000001,0\n")), InputError);
    EXPECT_THROW((void)read_polyline(write("x,y\n0,0\n1,1\n")), InputError);
}

}  // namespace
}  // namespace sc::host
