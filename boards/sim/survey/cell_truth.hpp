// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "boards/sim/rig/rig_files.hpp"

/// Where a robot with a 3-D sensor and the reference markers of a cell truly are. Metres, h unless said otherwise.

namespace sc::sim {

struct SurveyNoise {
    double marker = 7.5e-6;       ///< of each coordinate that the sensor sees, 1 sigma
    double robot_place = 6.7e-6;  ///< repeatability, each axis
    double robot_turn = 2.6e-5;   ///< radians
    double robot_bias = 0.35e-3;  ///< metres: what a robot with errors in its arms is off, smoothly over its room
    double width = 3e-6;          ///< of a stroke's width
};

/// Everything that a seed decides once and for all.
class CellTruth {
public:
    CellTruth(std::uint64_t seed, const SurveyNoise& noise);

    /// A view of `centre` from `distance` metres away in the direction `from`, rolled about its axis: h_from_c.
    [[nodiscard]] Pose look(const Vec3& centre, const Vec3& from, double distance, double roll = 0.0) const;
    /// What the robot says of itself with the sensor there: b_from_f, errors and noise in it.
    [[nodiscard]] Pose robot_reading(const Pose& h_from_c, Random& random) const;
    /// Markers round the table that stand still, with their ids.
    struct Reference {
        int id = 0;
        Vec3 place;
    };
    /// Those that a sensor there sees: the twelve nearest.
    [[nodiscard]] std::vector<Reference> references(const Pose& h_from_c) const;
    [[nodiscard]] const SurveyNoise& noise() const noexcept { return noise_; }
    /// Random numbers for one purpose: other draws do not change them.
    [[nodiscard]] Random random(std::uint64_t purpose) const;

private:
    std::uint64_t seed_;
    SurveyNoise noise_;
    Pose h_from_b_;
    Pose f_from_c_;
    std::vector<Reference> references_;
    std::vector<Vec3> wave_;   ///< radians per metre
    std::vector<Vec3> shift_;  ///< metres
    std::vector<Vec3> turn_;   ///< radians
    std::vector<double> phase_;
};

/// The three files of a set of views: rows grow, view by view.
struct ViewFiles {
    explicit ViewFiles(const CellTruth& truth, bool turns);
    /// A view from h_from_c of markers (id, place in h at that moment) at a reading of the table, degrees.
    void add(const std::string& view, const Pose& h_from_c, double turn_deg,
             const std::vector<CellTruth::Reference>& markers, Random& random);
    /// markers.csv, references.csv and robot.csv. Throws std::runtime_error.
    void write(const std::filesystem::path& folder) const;

private:
    const CellTruth* truth_;
    bool turns_;
    std::string markers_;
    std::string references_;
    std::string robot_;
};

}  // namespace sc::sim
