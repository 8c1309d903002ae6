// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "host/formats/stand.hpp"
#include "host/measurement/parallelism.hpp"

namespace sc::host {

/// Camera scale at a plate: a plane-to-plane map (eight numbers) from pixels to millimetres through all dots, which are
/// told apart by their corners first. For the sources of this folder. Throws InputError.
[[nodiscard]] PlateScale scale_of(const Stand& stand, const PlatePixels& pixels);

}  // namespace sc::host
