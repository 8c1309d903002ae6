// SPDX-License-Identifier: Apache-2.0
#include "host/cli/scribe_input.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include "host/bridge/child_process.hpp"
#include "host/cli/calibration_age.hpp"
#include "host/cli/number_text.hpp"
#include "host/cli/override.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

constexpr double kSameAngleDeg = 1e-6;

std::filesystem::path example_job() {
    const auto root = find_project_root();
    if (!root) {
        throw InputError({.file = {},
                          .problem = "the example job is not beside this program",
                          .value = {},
                          .action = "name a job file, or set SCRIBECELL_ROOT to the project's folder"});
    }
    return *root / "examples/ras3dm/job.toml";
}

bool same_angle(double a, double b) { return std::abs(a - b) < kSameAngleDeg; }

std::string angles_text(const Job& job) {
    std::string text;
    for (const JobFace& face : job.faces) {
        text += (text.empty() ? "" : ", ") + number_text(face.angle_deg);
    }
    for (const JobPath& path : job.paths) {
        text += (text.empty() ? "" : ", ") + number_text(path.face_deg);
    }
    return text;
}

/// Keeps the faces asked for, in the job's order.
void keep_faces(Job& job, const std::vector<double>& wanted) {
    const auto asked = [&](double angle) {
        return std::any_of(wanted.begin(), wanted.end(), [&](double w) { return same_angle(w, angle); });
    };
    for (const double angle : wanted) {
        const bool there = std::any_of(job.faces.begin(), job.faces.end(),
                                       [&](const JobFace& face) { return same_angle(angle, face.angle_deg); }) ||
                           std::any_of(job.paths.begin(), job.paths.end(),
                                       [&](const JobPath& path) { return same_angle(angle, path.face_deg); });
        if (!there) {
            throw InputError({.file = job.file.string(),
                              .problem = "the job has no such face",
                              .value = number_text(angle),
                              .action = "choose of: " + angles_text(job)});
        }
    }
    if (!wanted.empty()) {
        std::erase_if(job.faces, [&](const JobFace& face) { return !asked(face.angle_deg); });
        std::erase_if(job.paths, [&](const JobPath& path) { return !asked(path.face_deg); });
    }
}

void check_readable(const std::optional<std::filesystem::path>& file, const char* what) {
    if (file && !std::ifstream(*file)) {
        throw InputError({.file = file->string(),
                          .problem = std::string(what) + " cannot be read",
                          .value = {},
                          .action = "check the name"});
    }
}

/// Options that mean nothing to a cell that this program has not started.
void check_link_options(const ScribeOptions& options) {
    if (is_simulated(options.link)) {
        return;
    }
    const bool given = options.link_options.world || options.link_options.script || options.link_options.m7_image ||
                       options.link_options.board != "sim" || options.link_options.jitter > Nanoseconds::zero() ||
                       options.link_options.record;
    if (given) {
        throw InputError(
            {.file = {},
             .problem = "--world, --script, --jitter-us, --record, --board and --m7-image belong to the simulated cell",
             .value = options.link,
             .action = "give them to `scribecell cell`, or use --link sim:"});
    }
}

void check_preview(const ScribeOptions& options) {
    const auto refuse = [](const std::string& problem, const std::string& action) {
        throw InputError({.file = {}, .problem = problem, .value = {}, .action = action});
    };
    if (!options.preview && options.rounds) {
        refuse("--rounds belongs to --preview", "add --preview; to burn several times give passes in the job");
    }
    if (options.preview && (options.dry_run || options.journal || options.svg)) {
        refuse("a preview burns nothing: --dry-run, --journal and --svg do not go with it", "leave them out");
    }
}

void check_folder_of(const std::optional<std::filesystem::path>& file, const char* what) {
    const std::filesystem::path folder = file && file->has_parent_path() ? file->parent_path() : ".";
    if (file && !std::filesystem::is_directory(folder)) {
        throw InputError({.file = file->string(),
                          .problem = std::string("the folder of ") + what + " does not exist",
                          .value = folder.string(),
                          .action = "make it first"});
    }
}

}  // namespace

ScribeInput read_input(const ScribeOptions& options) {
    check_link_options(options);
    check_preview(options);
    if (options.override_percent) {
        check_override(*options.override_percent);
    }
    check_readable(options.link_options.world, "the world file");
    check_readable(options.link_options.script, "the fault script");
    check_readable(options.link_options.m7_image, "the image for the Cortex-M7");
    check_folder_of(options.svg, "the picture");
    check_folder_of(options.link_options.record, "the log of the inputs");
    check_folder_of(options.journal, "the journal");
    ScribeInput input;
    input.job = read_job(options.job.empty() ? example_job() : options.job);
    keep_faces(input.job, options.faces);
    input.points_from_table = options.table.has_value();
    input.table_file = options.table.value_or(input.job.table);
    const std::filesystem::path calibration = options.calibration.value_or(input.job.calibration);
    input.calibration = read_calibration(calibration);
    check_age(input.calibration, options.accept_expired);
    if (input.job.surface && !input.calibration.y_sensor) {
        throw InputError({.file = calibration.string(),
                          .problem = "the job has [surface], and this calibration does not say where the Y sensor is",
                          .value = "y_sensor",
                          .action = "add [y_sensor] to the calibration, or take [surface] out of the job"});
    }
    return input;
}

link::SetSurface surface_of(const Job& job, const CalibrationSet& calibration) {
    link::SetSurface out;
    if (!job.surface || !calibration.y_sensor) {
        return out;
    }
    const Vec3& origin = calibration.y_sensor->origin.v;
    const Vec3& direction = calibration.y_sensor->direction.v;
    out.mode = job.surface->follow ? 2 : 1;
    out.origin = {origin.x, origin.y, origin.z};
    out.direction = {direction.x, direction.y, direction.z};
    out.zero = calibration.y_sensor->zero;
    out.window = job.surface->window.si();
    out.bound = job.surface->bound.si();
    return out;
}

link::CheckSeating seating_of(const SeatingSettings& seating) {
    const auto wire = [](double metres) { return static_cast<std::int32_t>(std::lround(metres * kWireUnitsPerMetre)); };
    link::CheckSeating out;
    for (std::size_t i = 0; i < seating.expected.size(); ++i) {
        out.expected.at(i) = wire(seating.expected.at(i));
    }
    out.tolerance = wire(seating.tolerance.si());
    out.tilt = wire(seating.tilt.si());
    out.samples = static_cast<std::uint8_t>(seating.samples);
    return out;
}

Planned plan_for(const ScribeInput& input, const MachineConfig& machine) {
    Planned planned;
    if (!input.table_file.empty()) {
        planned.table = read_table(input.table_file, machine);
    }
    const PlanOptions options{.face = std::nullopt, .points_from_table = input.points_from_table};
    planned.plan =
        plan_job(input.job, planned.table, input.calibration, machine_of(input.calibration, machine), options);
    return planned;
}

std::string describe_item(const JobPlan& plan, std::size_t item) {
    const auto look = std::ranges::find(plan.looks, item, &PlannedLook::item);
    for (std::size_t i = 0; i < plan.paths.size(); ++i) {
        const PlannedPath& path = plan.paths[i];
        const bool looked_at = look != plan.looks.end();
        const bool its =
            looked_at ? look->path == i : item >= path.first_item && item < path.first_item + path.item_count;
        if (!its) {
            continue;
        }
        std::string text = looked_at ? "the Y sensor's look at the " : "";
        text += name_of(path.kind);
        if (!path.name.empty()) {
            text += " \"" + path.name + "\"";
        }
        if (path.marker != 0) {
            text += " of marker " + std::to_string(path.marker);
        }
        text += ", face " + number_text(path.face_deg) + " (" + path.source.file.string();
        if (path.source.line > 0) {
            text += " line " + std::to_string(path.source.line);
        }
        return text + ")";
    }
    return "a turn or the end of the job";
}

}  // namespace sc::host::cli
