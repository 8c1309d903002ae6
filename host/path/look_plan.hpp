// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "host/formats/calibration_set.hpp"
#include "host/path/job_plan.hpp"
#include "shared/machine/machine.hpp"

namespace sc::host {

/// Puts looks of the Y sensor before the paths of a plan, for `[surface]`. The sensor sees another place than the beam,
/// so the axes carry it along each marked stretch first, at places q = line − origin, where a surface that is where it
/// should be reads the sensor's zero. Looks come in groups of what the controller remembers (kSurfacePlaces), each
/// before the paths that it is for, never across a turn; what a look of the group has seen already (a further pass, a
/// stroke beside it) is not looked at again. Curves are looked at along chords within 0.2 mm of them.
///
/// `speed` in m/s. The plan's items, places of items in it, hash and estimate of time change; what is burnt does not.
/// Throws InputError, with the path's file and line, where the axes cannot take the sensor along a line, and for a path
/// that is longer than what can be remembered.
void add_looks(JobPlan& plan, const SensorRay& sensor, Speed speed, const MachineConfig& machine,
               const Compensation& compensation);

}  // namespace sc::host
