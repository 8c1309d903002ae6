// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/formats/calibration_set.hpp"

/// What the commands that calibrate transforms print and save alike.

namespace sc::host::cli {

[[nodiscard]] nlohmann::ordered_json vector_json(const Vec3& v);
/// {"rotation", "translation_mm", "quaternion_wxyz", "kuka_abc_deg", "sigma_rotation_mdeg", "sigma_translation_um",
/// "covariance"}; the covariance is in rad and m, of ξ (docs/frames.md).
[[nodiscard]] nlohmann::ordered_json transform_json(const Mat3& rotation, const Vec3& translation,
                                                    const Covariance<6>& covariance);
/// Matrix, place, and the angles that KUKA and FANUC show.
[[nodiscard]] std::string transform_text(const Mat3& rotation, const Vec3& translation);

struct SetFiles {
    std::string calibration;  ///< set to extend; empty: a new one
    std::string out;
};
/// The set with the record in place of one of the same id; returns its hash. `what` goes into the set's id. Throws
/// InputError.
std::string save_transform(const SetFiles& files, const std::string& what, TransformRecord record);

/// The same of several records, and of the turntable's axis if there is one, with covariances between them. Those of
/// replaced records with others are dropped.
std::string save_records(const SetFiles& files, const std::string& what, std::vector<TransformRecord> records,
                         std::optional<AxisRecord> turntable, std::vector<CrossCovariance> cross = {});

}  // namespace sc::host::cli
