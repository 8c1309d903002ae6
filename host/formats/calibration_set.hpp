// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/geometry/frames.hpp"
#include "shared/machine/axis_map.hpp"
#include "shared/machine/galvo_lag.hpp"
#include "shared/machine/machine.hpp"
#include "shared/machine/power_curve.hpp"

/// The calibration set: every estimate that the cell works with, each with its uncertainty. File: format =
/// "scribecell-calibration", version = 1 (docs/formats.md); signs and definitions: docs/frames.md. In memory all is SI:
/// metres, radians, plain ratios.

namespace sc::host {

/// Symmetric positive definite, row-major.
template <std::size_t N>
struct Covariance {
    std::array<std::array<double, N>, N> at{};
    bool operator==(const Covariance&) const noexcept = default;
};

/// How long a record holds; at most one of the two is given. Neither: it does not expire.
struct Validity {
    double days = 0.0;    ///< from the record's time on; 0: not given
    std::string expires;  ///< ISO 8601 with zone; empty: not given
    bool operator==(const Validity&) const = default;
};

/// How a record came about.
struct Provenance {
    std::vector<std::string> parents;  ///< ids of records or data sets that it was computed from
    double residual_rms = 0.0;         ///< metres, of the fit; for ratios at the reach of the data
    std::string time;                  ///< ISO 8601 with zone, e.g. 2026-01-31T12:00:00Z
    std::string note;
    Validity validity{};
    bool operator==(const Provenance&) const = default;
};

/// A transform `id` = "to_from_from". Covariance of ξ in T = Exp(ξ)·T̂ (left perturbation), order rx,ry,rz,tx,ty,tz:
/// rad², rad·m, m².
struct TransformRecord {
    std::string id;
    Mat3 rotation;
    Vec3 translation;
    Covariance<6> covariance;
    Provenance provenance;
    bool operator==(const TransformRecord&) const = default;
};
/// The turntable's axis. Covariance order px,py,dx,dy: the place where it meets the plane z = point.z, and the x and y
/// of its unit direction.
struct AxisRecord {
    AxisLine line;
    Covariance<4> covariance;
    Provenance provenance;
    bool operator==(const AxisRecord&) const = default;
};
/// A distance sensor's beam. The sensor rides beside the head: with the axes at q, reading r says that the surface is
/// at q + origin + (r − zero)·direction.
struct SensorRay {
    std::string id;
    Point<frame::H> origin;         ///< with the axes at zero
    Direction<frame::H> direction;  ///< unit, from the sensor outwards
    double zero = 0.0;              ///< reading at the origin, metres
    double sigma = 0.0;             ///< of the place along the beam, metres
    Provenance provenance;
    bool operator==(const SensorRay&) const = default;
};
/// What the two-parameter galvo model leaves over, on a square grid of commands from −half_field to +half_field.
struct GalvoResidual {
    double half_field = 0.0;                ///< metres
    std::size_t side = 0;                   ///< points along each edge, 2 or more
    std::vector<std::array<double, 2>> xz;  ///< metres; side·side, x runs fastest
    bool operator==(const GalvoResidual&) const = default;
};
/// Where the beam lands for a command g: focus + offset + matrix·g, in (x, z). Covariance order ox,oz,mxx,mxz,mzx,mzz:
/// m², m, 1.
struct GalvoRecord {
    std::array<double, 2> offset{};
    std::array<double, 4> matrix{1.0, 0.0, 0.0, 1.0};  ///< row-major: xx, xz, zx, zz
    Covariance<6> covariance;
    std::optional<GalvoResidual> residual;
    Provenance provenance;
    bool operator==(const GalvoRecord&) const = default;
};
/// Ray model of head and lens with what it leaves over: the field correction in three dimensions. Definitions:
/// host/calibration/galvo_model.hpp. Values, and the covariance's order: ox,oz,gx,gz,rotation,skew,f1,f2,f3,f4,ex,ez,
/// bend,tx,tz, all in metres and radians.
struct GalvoFieldRecord {
    static constexpr std::size_t kParameters = 15;
    double angle_scale = 0.0;  ///< metres of command per radian
    std::array<double, kParameters> value{};
    Covariance<kParameters> covariance;
    double residual_half = 0.0;                   ///< metres of command
    std::size_t residual_side = 0;                ///< 0: none
    std::vector<std::array<double, 2>> residual;  ///< metres, coefficients of a bicubic B-spline, x runs fastest
    Provenance provenance;
    bool operator==(const GalvoFieldRecord&) const = default;
};
/// How the mirrors follow their frames. Covariance order latency,frequency,damping: s, Hz, 1.
struct GalvoLagRecord {
    GalvoLag lag;
    Covariance<3> covariance;
    Provenance provenance;
    bool operator==(const GalvoLagRecord&) const = default;
};
/// Errors of the linear axes: for readings q the focus truly stands at p = A q,
///     p_x = (1 + scale_x)·q_x + xy·q_y + xz·q_z,  p_y = (1 + scale_y)·q_y + yz·q_z,  p_z = (1 + scale_z)·q_z.
/// Covariance order xy,xz,yz,sx,sy,sz.
struct AxesRecord {
    double squareness_xy = 0.0;  ///< rad: x per y
    double squareness_xz = 0.0;  ///< rad: x per z
    double squareness_yz = 0.0;  ///< rad: y per z
    std::array<double, 3> scale{};
    Covariance<6> covariance;
    Provenance provenance;
    bool operator==(const AxesRecord&) const = default;
};

/// What the matrix of the axes leaves over (shared/machine/axis_map.hpp).
struct AxisMapRecord {
    AxisMap map;
    Provenance provenance;
    bool operator==(const AxisMapRecord&) const = default;
};

/// Average power behind the lens over the power byte.
struct PowerRecord {
    PowerCurve curve;
    std::string time;
    std::string note;  ///< which meter, how long
    Validity validity{};
    bool operator==(const PowerRecord&) const = default;
};

/// The beam about its focus: its radius is √2 waists one Rayleigh length off focus, its peak fluence half.
struct BeamRecord {
    double waist = 0.0;            ///< 1/e² radius in focus, metres
    double rayleigh_length = 0.0;  ///< metres
    std::string time;
    std::string note;  ///< how measured
    Validity validity{};
    bool operator==(const BeamRecord&) const = default;

    /// Metres off focus at which the peak fluence is less by this share: z = z_R √(τ / (1 − τ)).
    [[nodiscard]] double depth_within(double tolerance) const noexcept;
};

/// One beam of the triple-laser head in its frame d (docs/measure.md): the surface that reading r tells of lies at
///     (ox, oy, 0) + (1 + gain)·(r − zero)·u,  u = (tx, ty, 1) / |(tx, ty, 1)|.
struct TripleRay {
    std::string id;
    std::array<double, 2> origin{};  ///< metres, where the beam meets z = 0 of d
    std::array<double, 2> tilt{};    ///< dx/dz, dy/dz
    double zero = 0.0;               ///< reading at the origin, metres
    double gain = 0.0;               ///< of the distance, less one
    double sigma = 0.0;              ///< of one reading, metres
    bool operator==(const TripleRay&) const = default;
};
/// Where the reference plane r lies in d: d_from_r.
struct TripleReference {
    Mat3 rotation;
    Vec3 translation;            ///< metres
    std::array<double, 2> at{};  ///< y, z in r: where distances are taken, metres
    bool operator==(const TripleReference&) const noexcept = default;
};
/// The triple-laser head. Covariance order: ox,oy,tx,ty,zero,gain of ray 1, 2, 3, then rx,ry,rz,tx,ty,tz of ξ in
/// d_from_r = Exp(ξ)·estimate; SI units. Without a reference its last six rows and columns mean nothing (unit matrix).
struct TripleRecord {
    static constexpr std::size_t kRayParameters = 18;
    static constexpr std::size_t kParameters = 24;
    std::array<TripleRay, 3> rays;
    std::array<double, 2> range{};  ///< least and most reading that is taken, metres
    std::optional<TripleReference> reference;
    Covariance<kParameters> covariance;
    Provenance provenance;
    bool operator==(const TripleRecord&) const = default;
};

/// What the estimates of two records share, of a fit that gave both: E[δa·δbᵀ], rows in the order of the first record's
/// covariance, columns in that of the second; SI units. Records are named as by `covariance_blocks`
/// (calibration_records.hpp).
struct CrossCovariance {
    std::array<std::string, 2> between;
    std::vector<std::vector<double>> at;
    bool operator==(const CrossCovariance&) const = default;
};

struct CalibrationSet {
    std::filesystem::path file;  ///< where it was read
    std::string id;
    std::vector<std::string> parents;  ///< ids of the sets that this one replaces or extends
    std::string time;
    std::string note;
    std::string sha256;  ///< hex, of the file without the line that holds it; set by read and write
    std::vector<TransformRecord> transforms;
    std::optional<AxisRecord> turntable;
    std::optional<AxesRecord> axes;
    std::optional<AxisMapRecord> axis_map;
    std::optional<GalvoRecord> galvo;
    std::optional<GalvoFieldRecord> galvo_field;  ///< is used in place of `galvo` where it is there
    std::optional<GalvoLagRecord> galvo_lag;
    std::optional<PowerRecord> power;
    std::optional<BeamRecord> beam;
    std::optional<SensorRay> y_sensor;
    std::vector<SensorRay> triple_head;  ///< none or three
    std::optional<TripleRecord> triple;  ///< of the measuring head, in its own frame
    std::vector<CrossCovariance> cross;  ///< none: records are independent

    /// Record by id, nullptr if it is not there.
    [[nodiscard]] const TransformRecord* find(std::string_view transform_id) const noexcept;
};

/// Throws InputError for all that is malformed: a rotation that is none ("not orthogonal", "left-handed"), a direction
/// that is no unit vector, a covariance that is not symmetric and positive (each by itself, and all of those that
/// cross-covariances join), an expiry before the record's time, an unknown or missing key, a file whose sha256 line
/// disagrees with its content (the line may be left out).
[[nodiscard]] CalibrationSet read_calibration(const std::filesystem::path& path);
/// Writes the set with its hash and returns the hash. Throws InputError if it cannot be written or would be refused.
std::string write_calibration(const std::filesystem::path& path, const CalibrationSet& set);

/// What of a chain is missing is named: throws InputError with the set's file.
[[nodiscard]] Rigid<frame::H, frame::C> h_from_c(const CalibrationSet& set);
[[nodiscard]] const AxisLine& turntable_axis(const CalibrationSet& set);

/// What the controller is to take out: axis_from_h = A⁻¹ (in full, not to first order), galvo_from_field = M⁻¹,
/// galvo_offset = −M⁻¹·offset. A record that is absent leaves its part the identity. The galvo's residual grid has no
/// place in Compensation and is not used.
[[nodiscard]] Compensation compensation_of(const CalibrationSet& set);
/// How the mirrors follow, or an empty one: then what the machine states holds.
[[nodiscard]] GalvoLag galvo_lag_of(const CalibrationSet& set);
/// The power curve, or a straight one.
[[nodiscard]] PowerCurve power_curve_of(const CalibrationSet& set);
/// The machine as the set knows it: its laser's greatest power is the curve's.
[[nodiscard]] MachineConfig machine_of(const CalibrationSet& set, MachineConfig machine);
/// The axis map, or the identity.
[[nodiscard]] AxisMap axis_map_of(const CalibrationSet& set);

}  // namespace sc::host
