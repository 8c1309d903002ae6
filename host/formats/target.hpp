// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "shared/geometry/vec.hpp"

namespace sc::host {

enum class TargetKind : std::uint8_t { fixed, mobile };  ///< frames g and m

struct TargetMarker {
    int id = 0;
    Vec3 place;          ///< metres, in the target's frame
    double sigma = 0.0;  ///< metres, per axis; 0: nominal, not measured
    bool operator==(const TargetMarker&) const noexcept = default;
};
/// A certified step of the mobile target.
struct TargetStep {
    int id = 0;
    double height = 0.0;       ///< metres over step 1, along the target's +y
    double uncertainty = 0.0;  ///< metres, one sigma
    std::vector<int> markers;  ///< ids of the markers that lie on it
    bool operator==(const TargetStep&) const = default;
};
/// A marker block. File: format = "scribecell-target", version = 1.
struct Target {
    std::string id;
    TargetKind kind = TargetKind::fixed;
    std::string certificate;
    std::vector<TargetMarker> markers;  ///< ids are unique
    std::vector<TargetStep> steps;      ///< each names markers that exist
    bool operator==(const Target&) const = default;
};

/// Both throw InputError (file, line, value, what to do).
[[nodiscard]] Target read_target(const std::filesystem::path& path);
void write_target(const std::filesystem::path& path, const Target& target);

}  // namespace sc::host
