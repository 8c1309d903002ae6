// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "host/path/job_plan.hpp"

namespace sc::host {

/// A job's free path, made of pieces. `steps` are its places in h. With arc_fit, what arcs take of the tolerance is
/// taken off the tolerance that the controller gets. Throws InputError for a place that comes twice in a row, an arc
/// whose places lie on one line, one wider than 100 m, and arcs with a tolerance under 0.1 µm.
[[nodiscard]] PlannedPath free_path(const Job& job, const JobPath& path, const std::vector<PathStep>& steps);

}  // namespace sc::host
