// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>

#include "host/formats/station_job.hpp"
#include "host/measurement/station.hpp"
#include "shared/geometry/vec.hpp"

/// Corrections for the off-line robot program: where each workpiece truly sits, in the robot's base, and how far that
/// is from where the program expects it.

namespace sc::host {

/// b_from_o: the frame of a workpiece's face. Its x runs into the face as x of r does at the target; turned from the
/// target's frame by what was measured, and by nothing else (a plane says nothing of the turn about its normal).
struct StationFrame {
    std::string station;
    int number = 1;  ///< of BASE, UFRAME
    Mat3 rotation;
    Vec3 translation;       ///< metres
    Mat3 nominal_rotation;  ///< where the program expects it: at the target
    Vec3 nominal_translation;
};

/// KUKA A, B, C and FANUC R, P, W, radians: rotation = Rz(a)·Ry(b)·Rx(c); b in [−90°, 90°]. At b = ±90° c is 0.
[[nodiscard]] std::array<double, 3> abc_of(const Mat3& rotation) noexcept;
/// q1 (the real part, 0 or more), q2, q3, q4, as ABB writes them.
[[nodiscard]] std::array<double, 4> quaternion_of(const Mat3& rotation) noexcept;

[[nodiscard]] StationFrame frame_of(const StationResult& result, const StationTarget& target, const StationRobot& robot,
                                    int number);

/// station,number,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg,q1,q2,q3,q4,dx_mm,dy_mm,dz_mm,turn_deg
[[nodiscard]] std::string frames_csv(std::span<const StationFrame> frames);
/// Assignments to BASE_DATA[n], KRL.
[[nodiscard]] std::string frames_kuka(std::span<const StationFrame> frames);
/// Module with a wobjdata a station, RAPID.
[[nodiscard]] std::string frames_abb(std::span<const StationFrame> frames);
/// TP program that sets UFRAME[n] from position registers of the same number.
[[nodiscard]] std::string frames_fanuc(std::span<const StationFrame> frames);

}  // namespace sc::host
