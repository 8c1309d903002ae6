// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/registration/stitch.hpp"

/// What the commands that register views take and print alike.

namespace sc::host::cli {

struct ChainWords {
    std::string scan_set;
    std::vector<std::string> targets;
    std::vector<int> still;
    bool ids_unknown = false;
    double tolerance_um = 100.0;
    double sensor_um = 7.5;
    double table_mdeg = 0.5;
    std::string robot = "weighed";
    double robot_um = 6.7;
    double robot_mdeg = 1.5;
    bool keep_all = false;
    std::string map;
    std::string svg;
    bool json = false;
};
void add_chain_words(CLI::App& sub, ChainWords& words);

[[nodiscard]] ScanTargets targets_of(const ChainWords& words);
[[nodiscard]] ChainOptions options_of(const ChainWords& words);

[[nodiscard]] nlohmann::ordered_json chain_json(const ChainResult& chain);
[[nodiscard]] std::string chain_text(const ChainResult& chain);
/// Marker map and residuals: seen from above (x, y of c as the axis or the markers lie), arrows 1000 times longer.
[[nodiscard]] std::string chain_svg(const ChainResult& chain, const std::string& title);
/// Writes the map of markers and the picture, where they were asked for.
void write_chain_files(const ChainWords& words, const ChainResult& chain);

}  // namespace sc::host::cli
