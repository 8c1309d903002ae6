// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "host/formats/poses.hpp"
#include "shared/geometry/frames.hpp"

/// Has anything moved since a target was stored? Markers as they were are compared with what a sensor sees now, through
/// robot poses and f_from_c if it rides on a robot. All residuals form one Gaussian vector: noise of the stored places
/// (shared by all views), of each sighting, and of each robot pose. Against "nothing has moved" stand: the target moved
/// in its frame; the sensor moved on its flange; the sensor's scale changed. The one that explains most (by the
/// Bayesian information criterion) is the suspect. Host only; milliseconds for ten views of a dozen markers.

namespace sc::host {

struct DriftView {
    std::string name;
    std::optional<Rigid<frame::B, frame::F>> b_from_f;  ///< none: markers are in the stored frame already
    std::vector<SeenMarker> markers;
};

struct DriftOptions {
    double limit = 20e-6;         ///< metres: a marker that is further off has drifted
    double marker = 7.5e-6;       ///< metres: noise of a coordinate that states none
    double robot_place = 6.7e-6;  ///< metres, each axis of a robot pose
    double robot_turn = 2.6e-5;   ///< radians
    bool target_moved = false;    ///< the target was put down again: its rigid move is no drift
};

enum class DriftCause : std::uint8_t { nothing, target, sensor, scale };

struct DriftHypothesis {
    DriftCause cause = DriftCause::nothing;
    double chi_squared = 0.0;
    int parameters = 0;
    double turn = 0.0;     ///< radians
    double place = 0.0;    ///< metres, at the middle of the markers
    double scale = 0.0;    ///< of the sensor, less one
    double largest = 0.0;  ///< metres: how far it moves a marker
    double sigma = 0.0;    ///< metres: of that
};
struct DriftMarker {
    int id = 0;
    Vec3 off;             ///< metres, now − then, mean over the views
    double chance = 1.0;  ///< of what the suspect leaves over, chi-squared of 3
    bool moved_alone = false;
};

struct DriftResult {
    bool drifted = false;
    DriftCause suspect = DriftCause::nothing;
    std::string text;     ///< one line for a person
    double chance = 1.0;  ///< that residuals are as large with nothing moved
    double freedom = 0.0;
    double seen_from = 0.0;                   ///< metres: a move of all markers by that much is seen in 95 of 100 cases
    std::vector<DriftHypothesis> hypotheses;  ///< "nothing" first
    std::vector<DriftMarker> markers;
    std::vector<std::string> notes;
};

[[nodiscard]] std::string_view name_of(DriftCause cause) noexcept;
/// The transform to suspect.
[[nodiscard]] std::string_view suspect_of(DriftCause cause, bool by_robot) noexcept;

/// Throws InputError (with `file`) for fewer than three common markers, and robot poses without f_from_c.
[[nodiscard]] DriftResult check_drift(const std::filesystem::path& file, const std::vector<SeenMarker>& stored,
                                      const std::vector<DriftView>& views,
                                      const std::optional<Rigid<frame::F, frame::C>>& f_from_c,
                                      const DriftOptions& options = {});

/// What the views say of the markers' places in the stored frame, averaged: to be stored.
[[nodiscard]] std::vector<SeenMarker> places_to_store(const std::vector<DriftView>& views,
                                                      const std::optional<Rigid<frame::F, frame::C>>& f_from_c,
                                                      const DriftOptions& options = {});

}  // namespace sc::host
