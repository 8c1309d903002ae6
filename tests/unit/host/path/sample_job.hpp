// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/formats/calibration_set.hpp"
#include "host/formats/error.hpp"
#include "host/formats/job.hpp"
#include "host/formats/table.hpp"
#include "host/path/job_plan.hpp"

/// A small job that the reference machine can do: two faces of four markers, crosses by galvo, lines by the axes.

namespace sc::host::sample {

using namespace literals;

inline MarkSettings galvo_settings() {
    return {.actuator = Actuator::galvo, .speed = 250_mm_s, .pitch = 20_um, .energy = 300.0_uJ};
}
inline MarkSettings axes_settings() {
    return {.actuator = Actuator::axes, .speed = 60_mm_s, .pitch = 20_um, .energy = 300.0_uJ};
}

inline Job job() {
    Job job;
    job.file = "sample/job.toml";
    job.name = "sample";
    job.table = "sample/table.csv";
    job.cross = CrossSettings{4_mm, galvo_settings()};
    job.datum_line = DatumLineSettings{60_mm, axes_settings()};
    job.faces = {{.line = 20, .angle_deg = 0.0, .frame = PlaceFrame::h, .points = {}, .datum_line = {}},
                 {.line = 25, .angle_deg = 90.0, .frame = PlaceFrame::h, .points = {}, .datum_line = {}}};
    return job;
}

/// Markers on y = −0.30 + 0.01·(x + 0.25) + 0.02·(z + 0.40), 60 by 40 mm apart.
inline double depth(double x, double z) { return -0.30 + 0.01 * (x + 0.25) + 0.02 * (z + 0.40); }
inline VerificationTable table() {
    VerificationTable table;
    table.file = "sample/table.csv";
    int line = 2;
    for (const double face : {0.0, 90.0}) {
        int no = 1;
        for (const double x : {-0.28, -0.22}) {
            for (const double z : {-0.42, -0.38}) {
                const Point<frame::H> place{{x, depth(x, z), z}};
                table.rows.push_back({line++, face, no++, place, place});
            }
        }
    }
    return table;
}

/// An axis at (−250, −470) mm and an h_from_c that turns and shifts; no errors of axes or galvo.
inline CalibrationSet calibration() {
    CalibrationSet set;
    set.file = "sample/calibration.toml";
    TransformRecord record;
    record.id = "h_from_c";
    record.rotation = {{Vec3{0.0, 0.0, 1.0}, Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 1.0, 0.0}}};
    record.translation = {-0.5, 0.25, 0.125};
    set.transforms.push_back(record);
    AxisRecord axis;
    axis.line = {{{-0.250, -0.470, 0.0}}, {{0.0, 0.0, 1.0}}};
    set.turntable = axis;
    return set;
}

inline JobPlan plan(const Job& job, const VerificationTable& table, const PlanOptions& options = {}) {
    return plan_job(job, table, calibration(), reference_machine(), options);
}

/// A file that goes away with the test.
class TempFile {
public:
    TempFile(std::string_view name, std::string_view text)
        : path_(std::filesystem::path(testing::TempDir()) / (std::to_string(getpid()) + "_" + std::string(name))) {
        std::ofstream(path_) << text;
    }
    TempFile(const TempFile&) = delete;
    TempFile& operator=(const TempFile&) = delete;
    ~TempFile() { std::filesystem::remove(path_); }
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

/// Runs `action`, which must throw InputError, and returns it.
inline InputError refusal_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const InputError& error) {
        return error;
    }
    ADD_FAILURE() << "no InputError was thrown";
    return InputError(InputProblem{});
}

}  // namespace sc::host::sample
