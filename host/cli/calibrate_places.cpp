// SPDX-License-Identifier: Apache-2.0
#include "host/cli/calibrate_places.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <numbers>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "host/measurement/robot_frames.hpp"

namespace sc::host::cli {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

CalibrationSet next_set(const SetFiles& files, const std::string& what) {
    CalibrationSet set;
    if (files.calibration.empty()) {
        set.id = what;
    } else {
        set = read_calibration(files.calibration);
        set.parents = {set.id};
        set.id += "+" + what;
    }
    set.time =
        fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                    fmt::gmtime(std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::system_clock::now())));
    return set;
}

}  // namespace

nlohmann::ordered_json vector_json(const Vec3& v) { return {v.x, v.y, v.z}; }

nlohmann::ordered_json transform_json(const Mat3& rotation, const Vec3& translation, const Covariance<6>& covariance) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const Vec3& row : rotation.row) {
        rows.push_back(vector_json(row));
    }
    const auto abc = abc_of(rotation);
    std::array<double, 6> sigma{};
    for (std::size_t i = 0; i < 6; ++i) {
        sigma[i] = std::sqrt(covariance.at[i][i]) * (i < 3 ? 1e3 / kDegree : 1e6);
    }
    return {{"rotation", rows},
            {"translation_mm", vector_json(1e3 * translation)},
            {"quaternion_wxyz", quaternion_of(rotation)},
            {"kuka_abc_deg", {abc[0] / kDegree, abc[1] / kDegree, abc[2] / kDegree}},
            {"sigma_rotation_mdeg", {sigma[0], sigma[1], sigma[2]}},
            {"sigma_translation_um", {sigma[3], sigma[4], sigma[5]}},
            {"covariance", covariance.at}};
}

std::string transform_text(const Mat3& rotation, const Vec3& translation) {
    std::string out;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3& row = rotation.row[i];
        out +=
            fmt::format("  {:>12.8f} {:>12.8f} {:>12.8f}   {:>12.4f} mm\n", row.x, row.y, row.z, translation[i] * 1e3);
    }
    const auto abc = abc_of(rotation);
    return out + fmt::format("  KUKA A {:.4f}, B {:.4f}, C {:.4f} deg; FANUC W {:.4f}, P {:.4f}, R {:.4f} deg\n",
                             abc[0] / kDegree, abc[1] / kDegree, abc[2] / kDegree, abc[2] / kDegree, abc[1] / kDegree,
                             abc[0] / kDegree);
}

std::string save_records(const SetFiles& files, const std::string& what, std::vector<TransformRecord> records,
                         std::optional<AxisRecord> turntable, std::vector<CrossCovariance> cross) {
    CalibrationSet set = next_set(files, what);
    std::vector<std::string> replaced;
    if (turntable) {
        replaced.emplace_back("turntable");
    }
    for (const TransformRecord& record : records) {
        replaced.push_back(record.id);
    }
    std::erase_if(set.cross, [&replaced](const CrossCovariance& c) {
        return std::ranges::find(replaced, c.between[0]) != replaced.end() ||
               std::ranges::find(replaced, c.between[1]) != replaced.end();
    });
    std::ranges::move(cross, std::back_inserter(set.cross));
    for (TransformRecord& record : records) {
        record.provenance.time = set.time;
        const auto same = std::ranges::find(set.transforms, record.id, &TransformRecord::id);
        if (same != set.transforms.end()) {
            *same = std::move(record);
        } else {
            set.transforms.push_back(std::move(record));
        }
    }
    if (turntable) {
        turntable->provenance.time = set.time;
        set.turntable = std::move(turntable);
    }
    return write_calibration(files.out, set);
}

std::string save_transform(const SetFiles& files, const std::string& what, TransformRecord record) {
    std::vector<TransformRecord> records;
    records.push_back(std::move(record));
    return save_records(files, what, std::move(records), std::nullopt);
}

}  // namespace sc::host::cli
