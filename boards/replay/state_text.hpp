// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "firmware/controller/controller.hpp"
#include "firmware/hal/io.hpp"
#include "firmware/recording/io_image.hpp"

namespace sc::replay {

/// A fault's record by names; null when there is none.
[[nodiscard]] nlohmann::ordered_json fault_json(const safety::FaultRecord& record);
/// Names of the faults whose bits are set.
[[nodiscard]] nlohmann::ordered_json faults_json(std::uint64_t faults);
[[nodiscard]] std::string name_of_state(std::uint8_t state);
[[nodiscard]] std::string_view name_of(recording::OutputPart part) noexcept;

/// The controller after a tick, in words and in units of the workshop: mm, degrees, seconds.
[[nodiscard]] nlohmann::ordered_json state_json(const Controller& controller, const ServoInputs& inputs,
                                                const ServoOutputs& outputs, const MachineConfig& machine);
/// The same as indented lines "name: value".
[[nodiscard]] std::string lines_of(const nlohmann::ordered_json& json);

}  // namespace sc::replay
