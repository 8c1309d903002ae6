// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace sc::host::cli {

/// `scribecell verify record`: a person points the beam at the marks of a table.
void add_verify_record(CLI::App& verify, int& exit_code);

}  // namespace sc::host::cli
