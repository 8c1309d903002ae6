// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>

#include "host/formats/iso_time.hpp"
#include "host/formats/text.hpp"
#include "host/formats/toml_reader.hpp"

namespace sc::host {

namespace {

/// How far a rotation may be off one, and a unit vector off its length: what a file with seven digits gives.
constexpr double kShapeTolerance = 1e-6;
/// Nearer than this a unit vector is left as it is, so that reading and writing does not change it.
constexpr double kUnitKept = 1e-13;

}  // namespace

Mat3 TomlReader::rotation(std::string_view key) {
    const auto rows = matrix(key, 3, 3);
    Mat3 out;
    for (std::size_t i = 0; i < 3; ++i) {
        out.row[i] = {rows[i][0], rows[i][1], rows[i][2]};
    }
    if (const double error = orthogonality_error(out); !(error <= kShapeTolerance)) {
        fail(key, "is no rotation: its rows are not orthonormal, off by", about(error),
             "give a rotation matrix with seven digits or more");
    }
    if (const double determinant = out.determinant(); determinant < 0.0) {
        fail(key, "is no rotation but a left-handed (mirror) matrix, determinant", about(determinant),
             "give right-handed frames: one axis or the order of points is reversed");
    }
    return out;
}

Vec3 TomlReader::unit_vector(std::string_view key) {
    const Vec3 v = vector(key);
    const double length = norm(v);
    if (!(std::abs(length - 1.0) <= kShapeTolerance)) {
        fail(key, "is no unit vector, its length is", about(length), "divide it by its length");
    }
    return std::abs(length - 1.0) <= kUnitKept ? v : (1.0 / length) * v;
}

std::string TomlReader::time(std::string_view key) {
    const std::string text = this->text(key);
    if (!parse_iso_time(text)) {
        fail(key, "is not an ISO 8601 time with a zone", shortened(text), "write it like 2026-01-31T12:00:00Z");
    }
    return text;
}

}  // namespace sc::host
