// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace sc::host::cli {

/// What is asked of one figure of a benchmark.
struct Asked {
    double value = 0.0;
    bool lower_is_better = true;
};

/// True when `value` is as good as asked or better; never for what is no number.
[[nodiscard]] bool meets(double value, const Asked& asked) noexcept;

/// The figures asked of one benchmark, from tests/bench/asked.toml: one table a benchmark, one line a figure,
/// `name = {asked = 5.0, better = "lower"}`. Throws InputError for a missing or malformed file and a missing table.
[[nodiscard]] std::map<std::string, Asked> read_asked(const std::filesystem::path& file, const std::string& bench);

}  // namespace sc::host::cli
