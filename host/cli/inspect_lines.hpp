// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "host/inspection/inspection.hpp"
#include "host/path/line_job.hpp"

namespace sc::host::cli {

struct LineFiles {
    std::filesystem::path folder;                      ///< made if it is not there
    std::optional<std::filesystem::path> calibration;  ///< none: no job
    std::vector<double> faces;                         ///< degrees
    double incidence_deg = 60.0;
    std::optional<MarkSettings> settings{};  ///< none: as the datum lines of the example
    bool plain = false;  ///< the faces given alone, nothing kept from edges or from poorly seen surface
};

/// Writes lines.dxf (w), and with a calibration lines.csv (c and h) and job.toml. `scan` in c. Throws InputError.
[[nodiscard]] std::optional<LineJob> write_lines(const Inspection& inspection, std::span<const Vec3> scan,
                                                 const LineFiles& files);
[[nodiscard]] nlohmann::ordered_json line_job_json(const LineJob& job);
[[nodiscard]] std::string line_job_text(const LineJob& job, const LineFiles& files);

}  // namespace sc::host::cli
