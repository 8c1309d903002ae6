// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/calibration_set.hpp"

/// A calibration set as a list of records, whatever each is: age, expiry and covariance by name. A transform goes by
/// its id, the others by their table: "turntable", "axes", "axis_map", "galvo", "galvo_field", "galvo_lag", "power",
/// "beam", "y_sensor", "triple_head 1" to "3", "triple".

namespace sc::host {

struct RecordSummary {
    std::string id;
    std::string time;
    Validity validity;
    std::vector<std::string> parents;
    std::optional<double> residual_rms;  ///< metres
    std::string note;
};
/// In the order of the file.
[[nodiscard]] std::vector<RecordSummary> record_summaries(const CalibrationSet& set);

/// When a record ends; nothing if it does not.
[[nodiscard]] std::optional<std::chrono::sys_seconds> expiry_of(const std::string& time, const Validity& validity);

struct ExpiredRecord {
    std::string id;
    std::chrono::sys_seconds since;
};
[[nodiscard]] std::vector<ExpiredRecord> expired_records(const CalibrationSet& set, std::chrono::sys_seconds now);

/// A record's covariance as a matrix, SI units.
struct CovarianceBlock {
    std::string id;
    std::string_view order;    ///< names of the quantities, with commas
    std::vector<int> lengths;  ///< of each: 1 in metres, 0 not
    std::vector<std::vector<double>> at;
};
/// Of every record that has one: transforms, turntable, axes, galvo, galvo_field, galvo_lag.
[[nodiscard]] std::vector<CovarianceBlock> covariance_blocks(const CalibrationSet& set);

/// All of these blocks in one, with the set's cross-covariances; zero where nothing is stated.
[[nodiscard]] std::vector<std::vector<double>> joint_covariance(const CalibrationSet& set,
                                                                const std::vector<CovarianceBlock>& blocks);

}  // namespace sc::host
