// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <vector>

#include "host/formats/scan.hpp"
#include "host/formats/scan_set.hpp"
#include "host/formats/target.hpp"
#include "host/registration/chain.hpp"

/// Scan sets and targets as the bundle takes them, and the clouds of all views in one c. Host only.

namespace sc::host {

struct ScanTargets {
    std::vector<Target> targets;  ///< their markers stand still; all others turn with the table
    std::vector<int> still;       ///< further ids that do
    bool ids_unknown = false;     ///< numbers in the views mean nothing: match by mutual distances
    double tolerance = 1e-4;      ///< metres, for that
};
/// Markers of a target of kind fixed that were measured (sigma above 0) are known places and make its frame c; only one
/// target may have such. Unknown numbers are found against the targets' places, or against the view before where the
/// table stands still; what stays unknown gets numbers from 900001 on. Throws InputError for a set whose views have no
/// markers, two targets with measured places, an id on two targets, and views whose markers match nothing.
[[nodiscard]] ChainInput chain_input(const ScanSet& set, const ScanTargets& targets);

/// The points of all views in c with the table at C = 0, each with its view's number. Throws InputError for a cloud
/// that cannot be read or lies further than 100 m away (another unit), and for a view without a pose.
[[nodiscard]] PointCloud stitch_clouds(const ScanSet& set, const ChainResult& chain, const LengthUnit& unit = {});

/// All markers as a target of kind fixed whose places are in c: the ring's map, for later scans.
[[nodiscard]] Target marker_map(const ChainResult& chain, const std::string& id);

}  // namespace sc::host
