// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "boards/replay/replayer.hpp"

namespace sc::replay {

/// What is wrong with a log that is not readable, where, and what to do; empty for a readable one.
[[nodiscard]] std::string problem_text(const std::string& file, recording::LogEnd end,
                                       const recording::LogReader& reader);

/// Result of a replay as one object; `docs/formats.md` lists its keys.
[[nodiscard]] nlohmann::ordered_json result_json(const std::string& file, const Replayer& replayer,
                                                 const ReplayResult& result);
/// The same in sentences.
[[nodiscard]] std::string result_text(const std::string& file, const Replayer& replayer, const ReplayResult& result);

}  // namespace sc::replay
