// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boards/mps2_an500/pc/m7_controller.hpp"

namespace sc::mps2_an500 {

inline M7Options image_under_test() { return {.image = SC_M7_IMAGE}; }

}  // namespace sc::mps2_an500
