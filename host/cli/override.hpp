// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sc::host::cli {

/// Throws InputError for a feed override that no cell takes.
void check_override(int percent);

}  // namespace sc::host::cli
