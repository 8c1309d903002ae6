// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace sc::host::cli {

/// `--key FILE` of a command that opens a link.
inline void add_key_option(CLI::App& app, std::optional<std::filesystem::path>& key) {
    app.add_option("--key", key, "file of the cell's key: commands are sealed with it (scribecell key makes one)")
        ->type_name("FILE");
}

}  // namespace sc::host::cli
