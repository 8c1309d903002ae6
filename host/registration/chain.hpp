// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/calibration/marker_check.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/formats/poses.hpp"
#include "shared/geometry/frames.hpp"

/// One joint bundle over all that a scan set saw: views of a 3-D sensor, markers that stand still (fixed and mobile
/// targets, a ring of reference markers around the table), markers that turn with the table, places pointed at in the
/// scribing frame, and the robot's poses. Unknown are the view poses, the places of all markers, h_from_c, the
/// turntable's axis, the true angle of each stop and, with a robot, where its base and its flange are. Everything
/// counts by its noise (Triggs and others, Bundle Adjustment: A Modern Synthesis, 2000), so that the covariance is the
/// inverse Hessian. Without places pointed at it is a registration alone.
///
/// c is the frame of the first view, or of the known places; the table stands at C = 0 in it. Views that follow each
/// other at the same C are one stop of the table. Host only; 34 views of 100 markers take some 50 ms.

namespace sc::host {

struct ChainView {
    MarkerView seen;  ///< `turn`: of the table, radians; absent: 0
    std::optional<Rigid<frame::B, frame::F>> b_from_f;
};

/// What robot poses are for.
enum class RobotUse : std::uint8_t {
    weighed,  ///< data, of the noise that they turn out to have, but no better than stated
    trusted,  ///< data, of the noise stated
    left_out,
};

struct ChainPrediction {
    int id = 0;
    double face_deg = 0.0;
};

struct ChainOptions {
    double sigma = 7.5e-6;         ///< metres, of a sensor's coordinate that states none
    double pointing = 10e-6;       ///< metres, of a place pointed at that states none
    double table = 8.73e-6;        ///< radians, of a stop (0.5 mdeg)
    double axes = 2.5e-6;          ///< metres, each coordinate: of a beam sent to a place
    double robot_place = 6.7e-6;   ///< metres, each axis of a robot pose
    double robot_turn = 2.618e-5;  ///< radians (1.5 mdeg)
    RobotUse robot = RobotUse::weighed;
    bool find_wrong = true;
    double most_turn = 8.7e-3;             ///< radians: more uncertainty than that is refused
    double most_place = 5e-3;              ///< metres
    std::vector<ChainPrediction> predict;  ///< markers whose place before the beam is asked for
};

struct ChainInput {
    std::filesystem::path file;
    std::vector<ChainView> views;
    std::set<int> still;            ///< ids that do not turn with the table
    std::vector<SeenMarker> known;  ///< places in c of some of those
    std::filesystem::path pointing_file;
    std::vector<MarkerView> pointing;  ///< places in h, by id; `turn` where the table stood, for markers on it
    struct Axis {
        Vec3 point;
        Vec3 direction;
    };
    std::optional<Axis> axis;  ///< in c, where it is known already and is not looked for
};

struct ChainViewResult {
    std::string name;
    Mat3 rotation;          ///< c_from_view
    Vec3 translation;       ///< metres
    double turn = 0.0;      ///< radians, as read
    double turn_off = 0.0;  ///< what fits less what was read
    bool turn_wrong = false;
    std::size_t markers = 0;      ///< used
    double rms = 0.0;             ///< metres, each coordinate
    double turn_sigma = 0.0;      ///< radians, of the pose, in the worst direction
    double place_sigma = 0.0;     ///< metres, of the markers' middle
    bool robot = false;           ///< its robot pose counts
    double robot_off = 0.0;       ///< metres, from what the robot says to what fits
    double robot_turn_off = 0.0;  ///< radians
};
struct ChainMarkerResult {
    int id = 0;
    bool turns = false;
    Vec3 place;  ///< in c, table at C = 0
    Covariance<3> covariance;
    std::size_t seen = 0;  ///< times, used
    std::size_t wrong = 0;
    double rms = 0.0;  ///< metres, each coordinate
};
/// A sighting and what is left of it, for pictures and tables.
struct ChainResidual {
    std::string view;  ///< empty: pointed at
    int id = 0;
    Vec3 place;     ///< of the marker in c at that moment
    Vec3 residual;  ///< metres, in c
    bool used = true;
};
struct ChainPlace {
    int id = 0;
    double face_deg = 0.0;
    Vec3 place;                ///< in h, with that face before the laser
    Covariance<3> covariance;  ///< of the mark less the beam sent there: with the table's and the axes' own noise
};

struct ChainResult {
    std::vector<ChainViewResult> views;
    std::vector<ChainMarkerResult> markers;
    std::vector<ChainResidual> residuals;
    std::vector<MarkerFinding> findings;  ///< swapped, misnumbered, wrong
    std::vector<std::string> notes;
    std::vector<ChainPlace> places;
    std::vector<std::string> bad_views;  ///< left out altogether; `notes` say why

    struct Transform {
        Mat3 rotation;
        Vec3 translation;
        Covariance<6> covariance;  ///< as in TransformRecord
    };
    std::optional<Transform> h_from_c;
    struct Axis {
        Vec3 point;                ///< in c, beside the middle of the markers that turn
        Vec3 direction;            ///< unit
        double turn_sigma = 0.0;   ///< radians, worst direction
        double place_sigma = 0.0;  ///< metres
    };
    std::optional<Axis> axis;
    struct AxisInH {
        AxisLine line;
        Covariance<4> covariance;  ///< as in AxisRecord
    };
    std::optional<AxisInH> axis_in_h;
    /// Of h_from_c's ξ and the axis in h together: rx,ry,rz,tx,ty,tz,px,py,dx,dy. Each alone overstates what both do to
    /// a place.
    std::optional<Covariance<10>> together;

    double rms = 0.0;  ///< metres, each coordinate of all sightings used
    double pointing_rms = 0.0;
    double chi_squared = 0.0;
    double freedom = 0.0;
    double raised = 1.0;       ///< factor by which the sigmas were raised since the data scatter more than stated
    double robot_ratio = 0.0;  ///< noise found over noise stated; 0: no robot
    [[nodiscard]] const ChainMarkerResult* find(int id) const noexcept;
};

/// Views that cannot be brought to the others are left out and named, up to a fifth of them. Throws InputError (with
/// the file): fewer than two views, more views without three markers in common with the others (named), markers on a
/// line, clouds and places in other units or mirrored, an angle that counts clockwise, too many wrong markers, fewer
/// than three markers pointed at, and data that leave a view, h_from_c or the axis more uncertain than the options
/// allow (the blind direction is named).
[[nodiscard]] ChainResult fit_chain(const ChainInput& input, const ChainOptions& options = {});

/// The same by closed forms in a chain, each taking what the one before gave as exact: view by view, mean places, rigid
/// transform. No covariance, and the axis only as the start has it. What the bundle is measured against.
[[nodiscard]] ChainResult chain_step_by_step(const ChainInput& input, const ChainOptions& options = {});

}  // namespace sc::host
