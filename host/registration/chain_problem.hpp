// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "host/registration/chain.hpp"
#include "host/registration/chain_fit.hpp"

/// A chain on its way from input to result. For chain.cpp and chain_result.cpp.

namespace sc::host {

/// Where a sight of the model comes from.
struct SightOrigin {
    bool pointed = false;
    std::size_t view = 0;  ///< of the input's views, or of its places pointed at
    int line = 0;
};
struct ChainProblem {
    ChainModel model;
    ChainState state;
    std::vector<int> ids;               ///< of the model's markers
    std::vector<SightOrigin> origins;   ///< of the model's sights
    std::vector<std::size_t> stop_of;   ///< of a view
    std::vector<bool> turn_wrong;       ///< of a stop
    std::optional<std::size_t> h_pose;  ///< c_from_h among the poses
    std::vector<MarkerFinding> findings;
    std::vector<std::string> notes;
    double chi_squared = 0.0;
    double robot_ratio = 0.0;
};

/// Registered view by view; nothing fitted jointly.
[[nodiscard]] ChainProblem start_chain(const ChainInput& input, const ChainOptions& options);
/// Without `spread`, no covariances are stated and nothing is refused for them.
[[nodiscard]] ChainResult chain_result(const ChainInput& input, const ChainOptions& options,
                                       const ChainProblem& problem, const ChainSystem::Spread* spread);

[[noreturn]] void refuse_chain(const ChainInput& input, int line, std::string problem, std::string value,
                               std::string action);

}  // namespace sc::host
