// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/cli/bench_figures.hpp"

namespace sc::host::cli {

/// From scan set to beam, on cells that scribecell-rig makes in `folder`, `options.sets` of each kind: 36 marks on four
/// faces, where the joint bundle says that they stand against where the beam meets them. *_95_um is the 95th percentile
/// of the axis values, *_max_median_um the median over the sets of the largest axis value. `rows` gets a line a figure.
[[nodiscard]] std::vector<Figure> bench_chain(const BenchOptions& options, const std::filesystem::path& folder,
                                              std::string& rows);

}  // namespace sc::host::cli
