// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/calibration_set.hpp"
#include "host/formats/toml_reader.hpp"
#include "host/formats/toml_writer.hpp"

/// What the calibration file's reader and writer share: keys, orders and units.

namespace sc::host {

inline constexpr std::string_view kCalibrationFormat = "scribecell-calibration";
inline constexpr std::string_view kRigidOrder = "rx,ry,rz,tx,ty,tz";
inline constexpr std::string_view kAxisOrder = "px,py,dx,dy";
inline constexpr std::string_view kGalvoOrder = "ox,oz,mxx,mxz,mzx,mzz";
inline constexpr std::string_view kGalvoFieldOrder = "ox,oz,gx,gz,rotation,skew,f1,f2,f3,f4,ex,ez,bend,tx,tz";
inline constexpr std::string_view kGalvoLagOrder = "latency,frequency,damping";
inline constexpr std::string_view kAxesOrder = "xy,xz,yz,sx,sy,sz";

/// For each quantity of a covariance: 1 if it is a length (in the file's unit), 0 if it is an angle or a ratio.
template <std::size_t N>
using Lengths = std::array<int, N>;
inline constexpr Lengths<6> kRigidLengths{0, 0, 0, 1, 1, 1};
inline constexpr Lengths<4> kAxisLengths{1, 1, 0, 0};
inline constexpr Lengths<6> kGalvoLengths{1, 1, 0, 0, 0, 0};
/// In SI units altogether.
inline constexpr Lengths<GalvoFieldRecord::kParameters> kGalvoFieldLengths{};
inline constexpr Lengths<3> kGalvoLagLengths{};
inline constexpr Lengths<6> kAxesLengths{0, 0, 0, 0, 0, 0};

/// A unit of length of a file: si = value · factor / divisor, one of which is 1.
struct LengthUnit {
    double factor = 1.0;
    double divisor = 1.0;
    [[nodiscard]] constexpr double to_si(double value, int power) const noexcept {
        const double f = power == 2 ? factor * factor : (power == 1 ? factor : 1.0);
        return value * f / divisor_of(power);
    }
    [[nodiscard]] constexpr double divisor_of(int power) const noexcept {
        return power == 2 ? divisor * divisor : (power == 1 ? divisor : 1.0);
    }
};
inline constexpr LengthUnit kMillimetre{1.0, 1e3};
inline constexpr LengthUnit kMetre{1.0, 1.0};
inline constexpr LengthUnit kInch{0.0254, 1.0};

/// Tables of an axis map: micrometres, millidegrees and microradians in the file, a million times that on the
/// controller's grid.
inline constexpr double kMapUnits = 1e6;
inline constexpr double kLargestCoefficient = 2000.0;
inline constexpr std::array<std::string_view, kTurnTables> kTurnKeys{"c_angle_mdeg", "c_shift_x_um",  "c_shift_y_um",
                                                                     "c_shift_z_um", "c_tilt_x_urad", "c_tilt_y_urad"};
/// "x_along_z_um"
[[nodiscard]] inline std::string map_key(std::size_t of, std::size_t along) {
    return std::string(1, "xyz"[of]) + "_along_" + "xyz"[along] + "_um";
}

/// Symmetric (to rounding) with positive pivots when scaled to a correlation matrix.
[[nodiscard]] bool is_positive_definite(const std::vector<std::vector<double>>& matrix);
/// Largest relative difference between a pair of mirrored entries.
[[nodiscard]] double asymmetry(const std::vector<std::vector<double>>& matrix);

/// Reads `covariance` as rows and `covariance_order`, which must be `order`.
[[nodiscard]] std::vector<std::vector<double>> read_covariance_rows(TomlReader& table, std::string_view order,
                                                                    std::size_t size);

template <std::size_t N>
[[nodiscard]] Covariance<N> read_covariance(TomlReader& table, std::string_view order, const Lengths<N>& lengths,
                                            const LengthUnit& unit) {
    const auto rows = read_covariance_rows(table, order, N);
    Covariance<N> out;
    for (std::size_t i = 0; i < N; ++i) {
        for (std::size_t j = 0; j < N; ++j) {
            out.at[i][j] = unit.to_si(rows[i][j], lengths[i] + lengths[j]);
        }
    }
    return out;
}

/// Writes `covariance_order` and `covariance`, lengths in millimetres.
template <std::size_t N>
void write_covariance(TomlWriter& out, const Covariance<N>& covariance, std::string_view order,
                      const Lengths<N>& lengths) {
    std::vector<std::vector<double>> rows(N, std::vector<double>(N));
    for (std::size_t i = 0; i < N; ++i) {
        for (std::size_t j = 0; j < N; ++j) {
            rows[i][j] = file_value(covariance.at[i][j], kMillimetre.divisor_of(lengths[i] + lengths[j]));
        }
    }
    out.text("covariance_order", order);
    out.matrix("covariance", rows);
}

/// SHA-256, in hex, of a file without its sha256 line and with LF ends.
[[nodiscard]] std::string hash_without_hash_line(std::string_view text);
[[nodiscard]] CalibrationSet parse_calibration(const std::filesystem::path& path, std::string_view text);

/// calibration_records.cpp.
[[nodiscard]] Validity read_validity(TomlReader& table, const std::string& time);
void write_validity(TomlWriter& out, const Validity& validity);
/// Needs all other records of the set.
void read_cross_covariances(TomlReader& root, CalibrationSet& set);
void write_cross_covariances(TomlWriter& out, const CalibrationSet& set);
/// The combined covariance of what cross-covariances join must be one. Throws InputError at `root`.
void check_joint_covariance(const TomlReader& root, const CalibrationSet& set);

/// calibration_triple.cpp.
[[nodiscard]] Provenance read_provenance(TomlReader& table);
void write_provenance(TomlWriter& out, const Provenance& provenance);
[[nodiscard]] TripleRecord read_triple(TomlReader& table);
void write_triple(TomlWriter& out, const TripleRecord& record);

}  // namespace sc::host
