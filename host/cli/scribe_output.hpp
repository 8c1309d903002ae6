// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "host/cli/scribe_run.hpp"

namespace sc::host::cli {

/// What a plan would burn: a table, one line a path.
[[nodiscard]] std::string plan_text(const ScribeOutcome& outcome);
/// The outcome as one object: the accuracy report; of a plan {"dry_run","job","items","paths":[…],…};
/// of a preview {"preview":{"rounds",…},"pulses",…}; of a job that
/// failed {"error":{…},"state","progress":{…},…}.
[[nodiscard]] nlohmann::ordered_json outcome_json(const ScribeOutcome& outcome);
/// What a preview has shown, for a person.
[[nodiscard]] std::string preview_text(const ScribeOutcome& outcome);
/// What the board of the controller measured (instructions, stack), for a person; empty when it ran on this PC.
[[nodiscard]] std::string board_text(const ScribeOutcome& outcome);
/// How far a job that ended early has come, for a person; ends with a line break.
[[nodiscard]] std::string how_far_text(const ScribeOutcome& outcome);

}  // namespace sc::host::cli
