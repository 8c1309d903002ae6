// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "host/inspection/inspection.hpp"
#include "host/inspection/uncertainty.hpp"

namespace sc::host {

/// For a person; millimetres and degrees.
[[nodiscard]] std::string inspection_text(const Inspection& inspection);
[[nodiscard]] nlohmann::ordered_json uncertainty_json(const Uncertainty& uncertainty);
/// For a program: docs/inspect.md.
[[nodiscard]] nlohmann::ordered_json inspection_json(const Inspection& inspection);

}  // namespace sc::host
