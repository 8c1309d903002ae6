// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "host/formats/calibration_set.hpp"
#include "host/formats/job.hpp"
#include "host/formats/table.hpp"
#include "host/path/job_plan.hpp"
#include "host/verification/accuracy.hpp"
#include "synthetic_burns.hpp"

namespace sc::host::synthetic {

/// The RAS3DM job, burnt by a cell that does what it is told plus `error`: from the plan straight to pulses.
struct Ras3dmRun {
    Job job = read_job(SC_SOURCE_DIR "/examples/ras3dm/job.toml");
    VerificationTable table = read_table(SC_SOURCE_DIR "/examples/ras3dm/table1.csv");
    CalibrationSet calibration = read_calibration(SC_SOURCE_DIR "/examples/ras3dm/calibration.toml");
    TraceHeader header{{{{kAxisX, kAxisY, 0.0}}, {{0.0, 0.0, 1.0}}}, {}, "", ""};
    PlanOptions options;
    double noise = 0.0;
    std::function<Vec3(const Vec3&)> error;
    std::function<bool(const PlannedPath&)> skip;
    std::function<void(Burner&)> also;

    [[nodiscard]] JobPlan plan() const { return plan_job(job, table, calibration, reference_machine(), options); }
    [[nodiscard]] BurnFindings find(const JobPlan& planned) const {
        Burner burner(9);
        burner.error = error;
        burner.noise = noise;
        burner.roughness = [](const Vec3& p) { return 30e-6 * std::sin(4e2 * p.x + 3e2 * p.z); };
        for (const PlannedPath& path : planned.paths) {
            if (!skip || !skip(path)) {
                burner.c_deg = -path.face_deg;
                burner.stroke(path.from.v, path.to.v);
            }
        }
        if (also) {
            also(burner);
        }
        return find_burns(burner.pulses, header.axis, face_angles(table));
    }
    [[nodiscard]] AccuracyReport assess() const {
        const JobPlan planned = plan();
        return host::assess(find(planned), table, planned, header, calibration);
    }
};

}  // namespace sc::host::synthetic
