// SPDX-License-Identifier: Apache-2.0
#include "host/formats/calibration_set.hpp"

#include <chrono>
#include <cmath>
#include <random>

#include "host/formats/calibration_records.hpp"
#include "host/formats/iso_time.hpp"
#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::line_with;
using test::replaced;
using test::TempDir;

const std::filesystem::path kExample = SC_SOURCE_DIR "/examples/ras3dm/calibration.toml";

/// The example without its hash, so that it may be edited.
std::string unsealed() {
    std::string text = test::slurp(kExample);
    const std::size_t at = text.find("sha256 = ");
    return text.erase(at, text.find('\n', at) + 1 - at);
}

void expect_bad(const std::string& from, const std::string& to, const std::string& at_line, const std::string& value,
                const std::string& problem) {
    const TempDir dir;
    const std::string text = replaced(unsealed(), from, to);
    const auto path = dir.write("calibration.toml", text);
    expect_refusal([&] { static_cast<void>(read_calibration(path)); },
                   {.file = path.string(), .line = line_with(text, at_line), .value = value, .problem = problem});
}

SensorRay ray(const std::string& id, double x) {
    SensorRay out;
    out.id = id;
    out.origin.v = {x, 0.01, -0.02};
    out.direction.v = {0.0, -1.0, 0.0};
    out.zero = 0.085;
    out.sigma = 1e-4;
    out.provenance = {.parents = {"axes"}, .residual_rms = 1e-5, .time = "2026-02-01T00:00:00+01:00", .note = ""};
    return out;
}

void expect_same(const CalibrationSet& a, const CalibrationSet& b) {
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.parents, b.parents);
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.note, b.note);
    EXPECT_EQ(a.transforms, b.transforms);
    EXPECT_EQ(a.turntable, b.turntable);
    EXPECT_EQ(a.axes, b.axes);
    EXPECT_EQ(a.cross, b.cross);
    EXPECT_EQ(a.galvo, b.galvo);
    EXPECT_EQ(a.galvo_field, b.galvo_field);
    EXPECT_EQ(a.y_sensor, b.y_sensor);
    EXPECT_EQ(a.triple_head, b.triple_head);
}

TEST(ReadCalibration, ReadsTheExample) {
    const CalibrationSet set = read_calibration(kExample);
    EXPECT_EQ(set.id, "reference-cell-1");
    ASSERT_EQ(set.transforms.size(), 1U);
    const TransformRecord& record = set.transforms[0];
    EXPECT_EQ(record.translation, (Vec3{-690.4172 / 1e3, 268.9351 / 1e3, 214.2846 / 1e3}));
    EXPECT_EQ(record.covariance.at[0][0], 8.1e-11);
    EXPECT_EQ(record.covariance.at[0][4], -2.835e-8 / 1e3) << "rad mm to rad m";
    EXPECT_EQ(record.covariance.at[3][3], 6.48189e-5 / 1e6) << "mm² to m²";
    EXPECT_EQ(record.provenance.residual_rms, 9.4 / 1e6);
    ASSERT_TRUE(set.turntable && set.axes && set.galvo && set.y_sensor);
    EXPECT_EQ(set.axes->squareness_xz, -0.0813 / 1e3);
    EXPECT_EQ(set.axes->scale[1], -7.3 / 1e6);
    EXPECT_NEAR(set.galvo->offset[1], -22e-6, 2e-6);
    ASSERT_TRUE(set.galvo_field);
    EXPECT_NEAR(set.galvo_field->value[6], 0.160, 0.5e-3) << "focal length";
    EXPECT_NEAR(norm(turntable_axis(set).direction.v), 1.0, 1e-15);
    EXPECT_EQ(h_from_c(set).translation, record.translation);
    EXPECT_EQ(set.find("b_from_c"), nullptr);
}

TEST(WriteCalibration, RoundTripsEveryRecord) {
    const TempDir dir;
    CalibrationSet set = read_calibration(kExample);
    set.parents = {"reference-cell-0"};
    set.transforms.push_back(set.transforms[0]);
    set.transforms[1].id = "b_from_c";
    set.transforms[1].provenance.note = "\"quoted\"";
    set.galvo->residual = GalvoResidual{.half_field = 0.02, .side = 2, .xz = {}};
    set.galvo->residual->xz = {{1.25e-6, -2e-6}, {0.0, 3.5e-7}, {1e-9, 0.0}, {-4e-6, 4e-6}};
    ASSERT_TRUE(set.galvo_field);
    set.galvo_field->residual_half = 0.06;
    set.galvo_field->residual_side = 4;
    set.galvo_field->residual.assign(16, {1.5e-6, -2.25e-7});
    set.triple_head = {ray("a", 0.0), ray("b", 0.1), ray("c", -0.1)};
    const std::string hash = write_calibration(dir / "c.toml", set);
    const CalibrationSet again = read_calibration(dir / "c.toml");
    expect_same(again, set);
    EXPECT_EQ(again.sha256, hash);
    EXPECT_EQ(write_calibration(dir / "d.toml", again), hash) << "the hash is of the content alone";
}

TEST(WriteCalibration, RoundTripsTheAxisMap) {
    const TempDir dir;
    CalibrationSet set = read_calibration(kExample);
    AxisMapRecord record{.map = {}, .provenance = set.transforms[0].provenance};
    record.map.first = {-0.45, -0.4, -0.5};
    record.map.spacing = {14e-3, 0.0, 15.625e-3};
    for (std::size_t k = 0; k < kMapCoefficients; ++k) {
        const auto number = static_cast<std::int32_t>(k);
        record.map.linear[0][0][k] = 1'234'567 * number - 20'000'000;  // pm
        record.map.linear[2][0][k] = -number;
        record.map.linear[1][2][k] = 25'000'001 - number * number;
    }
    for (std::size_t k = 0; k < kTurnNodes; ++k) {
        record.map.turn[0][k] = 123'457 * static_cast<std::int32_t>(k);  // nanodegrees
        record.map.turn[5][k] = 7 - static_cast<std::int32_t>(k);
    }
    record.map.pivot = {-0.25, -0.47, -0.4};
    record.map.backlash = {25'000'001, 0, 3, 6'000'001};
    record.map.take_up = {0.02, 0.03, 0.04, 0.05};
    set.axis_map = record;
    const std::string hash = write_calibration(dir / "c.toml", set);
    const CalibrationSet again = read_calibration(dir / "c.toml");
    ASSERT_TRUE(again.axis_map);
    EXPECT_EQ(again.axis_map->map, record.map);
    EXPECT_EQ(again.axis_map->provenance, record.provenance);
    EXPECT_EQ(axis_map_of(again), record.map) << "what the controller is given";
    EXPECT_EQ(write_calibration(dir / "d.toml", again), hash);
}

TEST(WriteCalibration, RoundTripsTheGalvosLag) {
    const TempDir dir;
    CalibrationSet set = read_calibration(kExample);
    EXPECT_TRUE(galvo_lag_of(set).empty());
    GalvoLagRecord record;
    record.lag = {173'774, Frequency::from_si(1585.85), 0.74604};
    record.covariance.at = {{{1e-14, 1e-8, 0.0}, {1e-8, 180.0, 0.01}, {0.0, 0.01, 8e-6}}};
    record.provenance = {
        .parents = {"lines"}, .residual_rms = 7.2e-6, .time = "2026-02-01T00:00:00+01:00", .note = "3196 marks"};
    set.galvo_lag = record;
    const std::string hash = write_calibration(dir / "c.toml", set);
    const CalibrationSet again = read_calibration(dir / "c.toml");
    EXPECT_EQ(galvo_lag_of(again), record.lag);
    EXPECT_EQ(again.galvo_lag->covariance, record.covariance);
    EXPECT_EQ(write_calibration(dir / "d.toml", again), hash);
    const std::string text = test::replaced(test::slurp(dir / "c.toml"), "latency_us = 173.774", "latency_us = 140.0");
    const auto bad = dir.write(
        "bad.toml", text.substr(0, text.find("sha256")) + text.substr(text.find('\n', text.find("sha256")) + 1));
    expect_refusal([&] { static_cast<void>(read_calibration(bad)); },
                   {.file = bad.string(),
                    .line = test::line_with(test::slurp(bad), "latency_us"),
                    .value = "140.0",
                    .problem = "below the servo's own lag"});
}

PowerRecord power_record() {
    PowerRecord record{.curve = {}, .time = "2026-02-01T00:00:00+01:00", .note = "thermopile, 10 s a point"};
    record.curve.count = 3;
    record.curve.byte = {16, 128, 255};
    record.curve.watts = {1.25, 33.4, 78.1};
    return record;
}

TEST(WriteCalibration, RoundTripsThePowerCurve) {
    const TempDir dir;
    CalibrationSet set = read_calibration(kExample);
    EXPECT_EQ(power_curve_of(set), PowerCurve{}) << "straight";
    EXPECT_EQ(machine_of(set, reference_machine()).laser.power, reference_machine().laser.power);
    set.power = power_record();
    const std::string hash = write_calibration(dir / "c.toml", set);
    const CalibrationSet again = read_calibration(dir / "c.toml");
    EXPECT_EQ(again.power, set.power);
    EXPECT_EQ(power_curve_of(again), set.power->curve);
    EXPECT_EQ(machine_of(again, reference_machine()).laser.power, Power::from_si(78.1)) << "what a job is checked by";
    EXPECT_EQ(write_calibration(dir / "d.toml", again), hash);
}

TEST(WriteCalibration, RoundTripsTheBeam) {
    const TempDir dir;
    CalibrationSet set = read_calibration(kExample);
    set.beam = BeamRecord{
        .waist = 25.0 / 1e6, .rayleigh_length = 0.6 / 1e3, .time = "2026-02-01T00:00:00+01:00", .note = "focus ladder"};
    write_calibration(dir / "c.toml", set);
    EXPECT_EQ(read_calibration(dir / "c.toml").beam, set.beam);
}

TEST(ReadCalibration, RefusesPowerCurvesThatAreNone) {
    const TempDir dir;
    CalibrationSet set = read_calibration(kExample);
    set.power = power_record();
    static_cast<void>(write_calibration(dir / "c.toml", set));
    const std::string good = test::slurp(dir / "c.toml");
    const auto bad = [&](const std::string& from, const std::string& to, const std::string& value,
                         const std::string& problem) {
        std::string text = test::replaced(good, from, to);
        text.erase(text.find("sha256"), text.find('\n', text.find("sha256")) + 1 - text.find("sha256"));
        const auto path = dir.write("bad.toml", text);
        expect_refusal([&] { static_cast<void>(read_calibration(path)); },
                       {.file = path.string(), .line = test::line_with(text, to), .value = value, .problem = problem});
    };
    bad("bytes = [16, 128, 255]", "bytes = [16, 255, 255]", "3 (255: 78.1 W)", "does not rise");
    bad("bytes = [16, 128, 255]", "bytes = [16, 128, 250]", "3 (250: 78.1 W)", "does not rise");
    bad("bytes = [16, 128, 255]", "bytes = [16, 128, 256]", "256", "outside 0..255");
    bad("bytes = [16, 128, 255]", "bytes = [255]", "1", "fewer than 2");
    bad("watts = [1.25, 33.4, 78.1]", "watts = [1.25, 33.4]", "2", "not as long");
    bad("watts = [1.25, 33.4, 78.1]", "watts = [1.25, 80.0, 78.1]", "3 (255: 78.1 W)", "does not rise");
}

TEST(WriteCalibration, RoundTripsArbitraryEstimates) {
    const TempDir dir;
    std::mt19937_64 random(20260131);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    CalibrationSet set = read_calibration(kExample);
    for (int i = 0; i < 50; ++i) {
        set.transforms[0].translation = {any(random), any(random), any(random)};
        set.axes->squareness_xy = 1e-3 * any(random);
        set.galvo->offset = {1e-4 * any(random), 1e-4 * any(random)};
        write_calibration(dir / "c.toml", set);
        const CalibrationSet first = read_calibration(dir / "c.toml");
        EXPECT_NEAR(first.transforms[0].translation.x, set.transforms[0].translation.x, 2.3e-16);
        EXPECT_NEAR(first.axes->squareness_xy, set.axes->squareness_xy, 1e-18);
        const std::string hash = write_calibration(dir / "c.toml", first);
        const CalibrationSet second = read_calibration(dir / "c.toml");
        expect_same(second, first);
        EXPECT_EQ(second.sha256, hash);
    }
}

TEST(ReadCalibration, KnowsMetresAndInches) {
    const TempDir dir;
    std::string text = replaced(unsealed(), "unit = \"mm\"", "unit = \"m\"");
    EXPECT_EQ(read_calibration(dir.write("m.toml", text)).transforms[0].translation.x, -690.4172);
    text = replaced(unsealed(), "unit = \"mm\"", "unit = \"inch\"");
    const CalibrationSet inch = read_calibration(dir.write("i.toml", text));
    EXPECT_DOUBLE_EQ(inch.transforms[0].translation.x, -690.4172 * 0.0254);
    EXPECT_DOUBLE_EQ(inch.transforms[0].covariance.at[3][3], 6.48189e-5 * 0.0254 * 0.0254);
    EXPECT_DOUBLE_EQ(inch.transforms[0].covariance.at[0][0], 8.1e-11);
}

std::string with_key(const std::string& table, const std::string& line) {
    return replaced(unsealed(), table + "\n", table + "\n" + line + "\n");
}

TEST(ReadCalibration, KnowsHowLongARecordHolds) {
    const TempDir dir;
    std::string text = with_key("[turntable]", "valid_days = 30.0");
    text = replaced(text, "[axes]\n", "[axes]\nexpires = \"2026-01-16T00:00:00+01:00\"\n");
    const CalibrationSet set = read_calibration(dir.write("c.toml", text));
    EXPECT_EQ(set.turntable->provenance.validity.days, 30.0);
    using std::chrono::sys_seconds;
    const sys_seconds turned = *parse_iso_time("2026-02-14T09:18:00Z");
    EXPECT_EQ(expiry_of(set.turntable->provenance.time, set.turntable->provenance.validity), turned);
    EXPECT_FALSE(expiry_of(set.transforms[0].provenance.time, set.transforms[0].provenance.validity));
    EXPECT_TRUE(expired_records(set, *parse_iso_time("2026-01-15T22:59:59Z")).empty());
    const auto one = expired_records(set, *parse_iso_time("2026-01-15T23:00:00Z"));
    ASSERT_EQ(one.size(), 1U);
    EXPECT_EQ(one[0].id, "axes");
    EXPECT_EQ(iso_time_text(one[0].since), "2026-01-15T23:00:00Z");
    EXPECT_EQ(expired_records(set, turned).size(), 2U);
    write_calibration(dir / "d.toml", set);
    expect_same(read_calibration(dir / "d.toml"), set);
}

TEST(ReadCalibration, RefusesExpiriesThatAreNone) {
    const auto bad = [](const std::string& line, const std::string& value, const std::string& problem) {
        const TempDir dir;
        const std::string text = with_key("[turntable]", line);
        const auto path = dir.write("c.toml", text);
        const std::string last = line.substr(line.rfind('\n') + 1);
        expect_refusal([&] { static_cast<void>(read_calibration(path)); },
                       {.file = path.string(), .line = line_with(text, last), .value = value, .problem = problem});
    };
    bad("valid_days = 0.0", "0.0", "valid_days");
    bad("expires = \"tomorrow\"", "tomorrow", "no");
    bad("expires = \"2026-01-15T09:18:00Z\"", "2026-01-15T09:18:00Z", "not after");
    bad("valid_days = 3.0\nexpires = \"2027-01-15T09:18:00Z\"", "2027-01-15T09:18:00Z", "beside valid_days");
}

/// h_from_c and the turntable's axis, estimated together: correlation r of tx and px.
CrossCovariance joined_estimate(const CalibrationSet& set, double r) {
    CrossCovariance cross{.between = {"h_from_c", "turntable"}, .at = {6, std::vector<double>(4, 0.0)}};
    cross.at[3][0] = r * std::sqrt(set.transforms[0].covariance.at[3][3] * set.turntable->covariance.at[0][0]);
    return cross;
}

TEST(WriteCalibration, RoundTripsCrossCovariances) {
    const TempDir dir;
    CalibrationSet set = read_calibration(kExample);
    set.cross = {joined_estimate(set, 0.3)};
    const std::string hash = write_calibration(dir / "c.toml", set);
    const CalibrationSet again = read_calibration(dir / "c.toml");
    ASSERT_EQ(again.cross.size(), 1U);
    EXPECT_DOUBLE_EQ(again.cross[0].at[3][0], set.cross[0].at[3][0]);
    EXPECT_EQ(write_calibration(dir / "d.toml", again), hash);
    const auto blocks = covariance_blocks(again);
    ASSERT_EQ(blocks[1].id, "turntable");
    const auto joint = joint_covariance(again, blocks);
    EXPECT_EQ(joint[3][6], again.cross[0].at[3][0]);
    EXPECT_EQ(joint[6][3], joint[3][6]);
    EXPECT_EQ(joint[0][0], again.transforms[0].covariance.at[0][0]);
    EXPECT_EQ(joint[9][9], again.turntable->covariance.at[3][3]);
}

TEST(WriteCalibration, RefusesCrossCovariancesThatCannotBe) {
    const TempDir dir;
    CalibrationSet set = read_calibration(kExample);
    set.cross = {joined_estimate(set, 0.99)};  // tx itself hangs on the rotations
    EXPECT_THROW(write_calibration(dir / "c.toml", set), InputError);
    set.cross = {joined_estimate(set, 0.1), joined_estimate(set, 0.1)};
    EXPECT_THROW(write_calibration(dir / "c.toml", set), InputError);
    set.cross = {joined_estimate(set, 0.1)};
    set.cross[0].between[1] = "power";
    EXPECT_THROW(write_calibration(dir / "c.toml", set), InputError);
    EXPECT_EQ(dir.files(), 0U);
}

TEST(ReadCalibration, HoldsTheContentAgainstItsHash) {
    const TempDir dir;
    const std::string sealed = test::slurp(kExample);
    EXPECT_EQ(read_calibration(kExample).sha256, read_calibration(dir.write("u.toml", unsealed())).sha256);
    std::string crlf;
    for (const char c : sealed) {
        crlf += c == '\n' ? "\r\n" : std::string(1, c);
    }
    EXPECT_NO_THROW(static_cast<void>(read_calibration(dir.write("crlf.toml", crlf))));
    const auto path =
        dir.write("c.toml", replaced(sealed, "squareness_xy_mrad = 0.1219", "squareness_xy_mrad = 0.1220"));
    expect_refusal([&] { static_cast<void>(read_calibration(path)); },
                   {.file = path.string(),
                    .line = line_with(sealed, "sha256"),
                    .value = read_calibration(kExample).sha256.substr(0, 60) + "...",
                    .problem = "does not belong to this content"});
}

TEST(ReadCalibration, RefusesRotationsThatAreNone) {
    const std::string row = "[-0.898666491062, -0.09557996051, 0.428092290272]";
    expect_bad(row, "[0.898666491062, 0.09557996051, -0.428092290272]", "rotation = [", "-1", "left-handed");
    expect_bad(row, "[-0.898667491062, -0.09557996051, 0.428092290272]", "rotation = [", "1.797e-06",
               "not orthonormal");
    expect_bad(row, "[-0.898666491062, -0.09557996051]", "rotation = [", "a list", "wrong shape");
    expect_bad(row + ",", "", "rotation = [", "2", "wrong number of rows");
}

TEST(ReadCalibration, RefusesDirectionsThatAreNone) {
    expect_bad("direction = [4.24e-5, -2.77e-5, 1.0]", "direction = [0.0, 0.0, 2.0]", "direction", "2",
               "no unit vector");
    expect_bad("direction = [4.24e-5, -2.77e-5, 1.0]", "direction = [0.0, 0.0, 0.0]", "direction", "0",
               "no unit vector");
    expect_bad("direction = [4.24e-5, -2.77e-5, 1.0]", "direction = [0.0, 0.0, -1.0]", "direction", "-1.0",
               "does not point up");
}

TEST(ReadCalibration, RefusesCovariancesThatAreNone) {
    expect_bad("[0.0, 6.4e-11, 0.0, 2.24e-8,", "[0.0, 6.4e-11, 0.0, 2.25e-8,", "covariance = [", "0.001553",
               "not symmetric");
    expect_bad("[8.1e-11, 0.0,", "[-8.1e-11, 0.0,", "covariance = [", "-8.1e-11", "is not positive: variance 1");
    expect_bad("covariance_order = \"rx,ry,rz,tx,ty,tz\"", "covariance_order = \"tx,ty,tz,rx,ry,rz\"",
               "covariance_order", "tx,ty,tz,rx,ry,rz", "is not the order");
    expect_bad("perturbation = \"left\"", "perturbation = \"right\"", "perturbation", "right", "unknown value");
    // Correlation of 2 between two variances that are positive by themselves.
    expect_bad("    [1.0e-6, 0.0, 0.0, 0.0],\n    [0.0, 1.0e-6, 0.0, 0.0],",
               "    [1.0e-6, 2.0e-6, 0.0, 0.0],\n    [2.0e-6, 1.0e-6, 0.0, 0.0],",
               "covariance = [\n    [1.0e-6, 2.0e-6", "a combination of px,py,dx,dy has none", "not positive definite");
}

TEST(ReadCalibration, RefusesTimesThatAreNone) {
    for (const std::string time : {"yesterday", "2026-01-15T09:30:00", "2026-02-30T00:00:00Z", "2026-01-15 09:30:00Z",
                                   "2026-01-15T24:00:00Z", "2026-01-15T09:30:00+25:00"}) {
        expect_bad("time = \"2026-01-15T09:30:00Z\"", "time = \"" + time + "\"", "time = ", time,
                   "not an ISO 8601 time");
    }
}

TEST(ReadCalibration, RefusesUnknownRepeatedAndMissing) {
    expect_bad("[axes]\n", "[axes]\nsquareness_zx_mrad = 0.0\n", "squareness_zx_mrad", "axes.squareness_zx_mrad",
               "unknown key");
    expect_bad("scale_x_ppm = 11.2\n", "", "[axes]", "axes.scale_x_ppm", "key is missing");
    expect_bad("matrix = [\n    [1.002830880691257, -0.001907492466417086],",
               "matrix = [\n    [-1.002830880691257, -0.001907492466417086],", "matrix", "-1.001", "mirrored");
    expect_bad("unit = \"mm\"", "unit = \"cm\"", "unit", "cm", "unknown value");
    expect_bad("[y_sensor]", "[[triple_head]]", "[[triple_head]]", "1", "not three rays");
}

TEST(CalibrationSet, NamesWhatAChainLacks) {
    CalibrationSet set;
    set.file = "c.toml";
    expect_refusal([&] { static_cast<void>(h_from_c(set)); },
                   {.file = "c.toml", .value = "transform h_from_c", .problem = "lacks a record"});
    expect_refusal([&] { static_cast<void>(turntable_axis(set)); },
                   {.file = "c.toml", .value = "turntable", .problem = "lacks a record"});
}

TEST(CompensationOf, IsTheIdentityWithoutRecords) { EXPECT_EQ(compensation_of(CalibrationSet{}), Compensation{}); }

TEST(CompensationOf, UndoesTheErrorsExactly) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    for (int i = 0; i < 2000; ++i) {
        CalibrationSet set;
        AxesRecord axes;
        axes.squareness_xy = 0.05 * any(random);
        axes.squareness_xz = 0.05 * any(random);
        axes.squareness_yz = 0.05 * any(random);
        axes.scale = {0.05 * any(random), 0.05 * any(random), 0.05 * any(random)};
        set.axes = axes;
        GalvoRecord galvo;
        galvo.offset = {1e-3 * any(random), 1e-3 * any(random)};
        galvo.matrix = {1.0 + 0.1 * any(random), 0.1 * any(random), 0.1 * any(random), 1.0 + 0.1 * any(random)};
        set.galvo = galvo;
        const Compensation c = compensation_of(set);

        const Vec3 place{any(random), any(random), any(random)};
        const Vec3 q = c.axis_from_h * place + c.axis_offset;
        const Vec3 p{q.x * (1 + axes.scale[0]) + axes.squareness_xy * q.y + axes.squareness_xz * q.z,
                     q.y * (1 + axes.scale[1]) + axes.squareness_yz * q.z, q.z * (1 + axes.scale[2])};
        ASSERT_LT(norm(p - place), 1e-15 * 4);

        const double fx = 0.02 * any(random);
        const double fz = 0.02 * any(random);
        const double gx = c.galvo_from_field[0] * fx + c.galvo_from_field[1] * fz + c.galvo_offset[0];
        const double gz = c.galvo_from_field[2] * fx + c.galvo_from_field[3] * fz + c.galvo_offset[1];
        ASSERT_NEAR(galvo.offset[0] + galvo.matrix[0] * gx + galvo.matrix[1] * gz, fx, 1e-17);
        ASSERT_NEAR(galvo.offset[1] + galvo.matrix[2] * gx + galvo.matrix[3] * gz, fz, 1e-17);
    }
}

}  // namespace
}  // namespace sc::host
