// SPDX-License-Identifier: Apache-2.0
#include "host/formats/station_job.hpp"

#include <numbers>
#include <set>

#include "host/formats/file.hpp"
#include "host/formats/text.hpp"
#include "host/formats/toml_reader.hpp"

namespace sc::host {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr Limits kDistanceMm{-100'000.0, 100'000.0};

std::array<double, 2> two_mm(TomlReader& table, std::string_view key) {
    const auto v = table.numbers(key, 2);
    return {v[0] / 1e3, v[1] / 1e3};
}

StationTarget read_target(TomlReader& table) {
    StationTarget target;
    target.same = table.choice("sit", {"as_given", "as_the_median"}) == 1;
    if (!target.same) {
        target.angle = table.number("angle_deg", {10.0, 170.0}) * kDegree;
        target.yaw = table.number_or("yaw_deg", 0.0, {-80.0, 80.0}) * kDegree;
        target.distance = table.number("distance_mm", kDistanceMm) / 1e3;
    }
    table.finish();
    return target;
}

void read_screws(TomlReader& root, StationJob& job) {
    std::set<std::string> seen;
    for (TomlReader& table : root.tables("screw")) {
        StationScrew screw;
        screw.id = table.text("id");
        screw.place = two_mm(table, "place_mm");
        screw.pitch = table.number("pitch_mm", {1e-3, 100.0}) / 1e3;
        if (!seen.insert(screw.id).second) {
            table.fail("id", "appears twice", shortened(screw.id), "name each screw once");
        }
        table.finish();
        job.screws.push_back(screw);
    }
    if (!job.screws.empty() && job.screws.size() != 3) {
        root.fail("screw", "are not three", std::to_string(job.screws.size()), "three screws set a plane: give three");
    }
    if (job.screws.size() == 3) {
        const auto& a = job.screws[0].place;
        const auto& b = job.screws[1].place;
        const auto& c = job.screws[2].place;
        const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if (!(area > 1e-6 || area < -1e-6)) {
            root.fail("screw", "lie on one line; they span, in mm2,", about(area * 0.5e6), "correct their places");
        }
    }
}

StationRobot read_robot(TomlReader& table) {
    StationRobot robot;
    robot.rotation = table.rotation("rotation");
    robot.translation = table.vector_mm("translation_mm");
    robot.rail = table.unit_vector("rail");
    robot.first_number = static_cast<int>(table.integer_or("first_number", 1, 1, 10'000));
    table.finish();
    return robot;
}

}  // namespace

StationJob default_station_job() { return {}; }

StationJob read_station_job(const std::filesystem::path& path) {
    TomlDocument document(path, read_text_file(path), "scribecell-measure");
    TomlReader& root = document.root();
    StationJob job;
    job.file = path;
    if (root.has("calibration")) {
        job.calibration = beside(path, root.text("calibration"));
    }
    if (root.has("readings")) {
        job.readings = beside(path, root.text("readings"));
    }
    if (root.has("at_mm")) {
        job.at = two_mm(root, "at_mm");
        job.at_given = true;
    }
    job.oldest = root.number_or("oldest_ms", 200.0, {1.0, 1e7}) / 1e3;
    job.fewest = static_cast<int>(root.integer_or("fewest_readings", 3, 1, 100'000));
    if (auto table = root.table_if("target")) {
        job.target = read_target(*table);
    }
    if (auto table = root.table_if("tolerance")) {
        job.angle_tolerance = table->number("angle_deg", {1e-4, 45.0}) * kDegree;
        job.distance_tolerance = table->number("distance_mm", {1e-4, 1e4}) / 1e3;
        table->finish();
    }
    if (auto table = root.table_if("seat")) {
        job.seat.angle = table->number("sigma_deg", {0.0, 10.0}) * kDegree;
        job.seat.place = table->number("sigma_mm", {0.0, 100.0}) / 1e3;
        table->finish();
    }
    if (auto table = root.table_if("robot")) {
        job.robot = read_robot(*table);
    }
    read_screws(root, job);
    root.finish();
    return job;
}

}  // namespace sc::host
