// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "host/calibration/hand_eye.hpp"
#include "host/calibration/hand_eye_fit.hpp"

/// What comes before the fit of a hand-eye calibration: markers, order, conventions, the closed form. For hand_eye.cpp.

namespace sc::host {

/// One view on its way through the calibration.
struct HandEyeEntry {
    const HandEyeView* view = nullptr;  ///< of HandEyeSetup::views
    Motion f;                           ///< b_from_f
    Motion c;                           ///< c_from_g
    bool used = true;
};
struct HandEyeSetup {
    std::vector<HandEyeView> views;  ///< with the markers that the fit takes
    std::vector<HandEyeEntry> entries;
    HandEyeStart start;
    HandEyeResult found;  ///< markers, notes, conventions
    bool poses_given = false;
};
/// Throws InputError as calibrate_hand_eye does.
[[nodiscard]] HandEyeSetup set_up_hand_eye(const std::filesystem::path& file, std::vector<HandEyeView> views,
                                           const HandEyeOptions& options);

}  // namespace sc::host
