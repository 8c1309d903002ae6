// SPDX-License-Identifier: Apache-2.0
#include "host/formats/poses.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/length_unit.hpp"
#include "host/formats/text.hpp"

namespace sc::host {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kFarthest = 100.0;        ///< metres
constexpr double kNormTolerance = 2e-3;    ///< a quaternion of four digits still passes
constexpr double kMatrixTolerance = 1e-3;  ///< so does a matrix of four digits
constexpr double kLargestSigmaUm = 1e6;

std::string lower(std::string_view text) {
    std::string out(text);
    std::ranges::transform(out, out.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return out;
}

CsvTable read_csv(const std::filesystem::path& path, const PoseFileWords& words) {
    const std::string text = read_text_file(path);
    return words.columns.empty() ? CsvTable::parse(path, text) : CsvTable::parse(path, text, words.columns);
}

/// A file's columns by what they mean; robots write their letters large.
class Columns {
public:
    explicit Columns(const CsvTable& csv) : csv_(csv) {
        for (const std::string& name : csv.columns()) {
            names_.push_back(lower(name));
        }
        used_.assign(names_.size(), false);
    }
    /// Index of the column, which is then known; nothing where there is none.
    std::optional<std::size_t> take(std::string_view name) {
        const auto at = std::ranges::find(names_, name);
        if (at == names_.end()) {
            return std::nullopt;
        }
        const auto index = static_cast<std::size_t>(at - names_.begin());
        used_[index] = true;
        return index;
    }
    template <std::size_t N>
    std::optional<std::array<std::size_t, N>> take_all(const std::array<std::string_view, N>& names) {
        std::array<std::size_t, N> out{};
        for (std::size_t i = 0; i < N; ++i) {
            const auto at = std::ranges::find(names_, names[i]);
            if (at == names_.end()) {
                return std::nullopt;
            }
            out[i] = static_cast<std::size_t>(at - names_.begin());
        }
        for (const std::size_t index : out) {
            used_[index] = true;
        }
        return out;
    }
    void refuse_rest(const std::string& action) const {
        for (std::size_t i = 0; i < names_.size(); ++i) {
            if (!used_[i]) {
                refuse("unknown column", shortened(csv_.columns()[i]), action);
            }
        }
    }
    [[noreturn]] void refuse(std::string problem, std::string value, std::string action) const {
        throw InputError({.file = csv_.file().string(),
                          .line = csv_.header_line(),
                          .problem = std::move(problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }

private:
    const CsvTable& csv_;
    std::vector<std::string> names_;
    std::vector<bool> used_;
};

/// Where the three coordinates stand, and their unit.
struct PlaceColumns {
    std::array<std::size_t, 3> at{};
    double metres = 1.0;
};

PlaceColumns take_place(Columns& columns, const PoseFileWords& words) {
    std::array<std::string, 3> found;
    PlaceColumns out;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string letter(1, "xyz"[axis]);
        for (const char* unit : {"um", "mm", "cm", "m", "inch", "in", "foot", "ft"}) {
            if (const auto at = columns.take(letter + "_" + unit)) {
                if (!found[axis].empty()) {
                    columns.refuse("column appears in two units", letter, "keep one of them");
                }
                out.at[axis] = *at;
                found[axis] = unit;
            }
        }
        if (const auto at = columns.take(letter)) {
            if (!found[axis].empty()) {
                columns.refuse("column appears with and without a unit", letter, "keep one of them");
            }
            if (words.unit.empty()) {
                columns.refuse("the unit is not known of column", letter,
                               "name it " + letter + "_mm (_m, _inch), or say --unit");
            }
            out.at[axis] = *at;
            found[axis] = words.unit;
        }
        if (found[axis].empty()) {
            columns.refuse("column is missing", letter + "_mm", "give x, y and z with their unit: _mm, _m, _inch");
        }
    }
    if (found[0] != found[1] || found[1] != found[2]) {
        columns.refuse("x, y and z are in mixed units", found[0] + ", " + found[1] + ", " + found[2],
                       "give all three in one unit");
    }
    const auto unit = length_unit(found[0]);
    if (!unit) {
        columns.refuse("is no unit of length", shortened(found[0]), "say one of " + length_unit_names());
    }
    out.metres = unit->metres;
    return out;
}

/// An angle of a turntable or a tilt: radians or degrees, by name.
struct AngleColumn {
    std::optional<std::size_t> at;
    double radians = 1.0;
};

AngleColumn take_angle(Columns& columns, const std::vector<std::string_view>& stems) {
    for (const std::string_view stem : stems) {
        for (const bool degrees : {true, false}) {
            if (const auto at = columns.take(std::string(stem) + (degrees ? "_deg" : "_rad"))) {
                return {at, degrees ? kDegree : 1.0};
            }
        }
    }
    return {};
}

/// What says which view a row belongs to.
struct ViewColumns {
    std::optional<std::size_t> view;
    std::optional<std::size_t> time;
};

ViewColumns take_view(Columns& columns) { return {columns.take("view"), columns.take("time_s")}; }

class RowReader {
public:
    explicit RowReader(const CsvTable& csv) : csv_(csv) {}

    [[noreturn]] void refuse(std::size_t row, std::string problem, std::string value, std::string action) const {
        throw InputError({.file = csv_.file().string(),
                          .line = csv_.line(row),
                          .problem = std::move(problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }
    [[nodiscard]] Vec3 place(std::size_t row, const PlaceColumns& columns) const {
        std::array<double, 3> v{};
        for (std::size_t i = 0; i < 3; ++i) {
            v[i] = csv_.number(row, columns.at[i]) * columns.metres;
            if (std::abs(v[i]) > kFarthest) {
                refuse(row, "is further than 100 m away in the unit of column " + csv_.columns()[columns.at[i]],
                       shortened(csv_.text(row, columns.at[i])), "check the unit of the file");
            }
        }
        return {v[0], v[1], v[2]};
    }
    [[nodiscard]] std::optional<double> angle(std::size_t row, const AngleColumn& column) const {
        return column.at ? std::optional(csv_.number(row, *column.at) * column.radians) : std::nullopt;
    }
    [[nodiscard]] std::optional<double> time(std::size_t row, const ViewColumns& columns) const {
        return columns.time ? std::optional(csv_.number(row, *columns.time)) : std::nullopt;
    }
    [[nodiscard]] std::string view(std::size_t row, const ViewColumns& columns) const {
        if (columns.view) {
            std::string name = csv_.text(row, *columns.view);
            if (name.empty()) {
                refuse(row, "view has no name", "", "name each view");
            }
            return name;
        }
        return columns.time ? csv_.text(row, *columns.time) : std::to_string(row + 1);
    }

private:
    const CsvTable& csv_;
};

/// The columns of the rotation, in the order in which their convention counts.
struct RotationColumns {
    PoseConvention convention = PoseConvention::quaternion;
    std::vector<std::size_t> at;
};

template <std::size_t N>
void offer(Columns& columns, std::vector<RotationColumns>& found, PoseConvention convention,
           const std::array<std::string_view, N>& names) {
    if (const auto at = columns.take_all(names)) {
        found.push_back({convention, {at->begin(), at->end()}});
    }
}

RotationColumns take_rotation(Columns& columns) {
    using Three = std::array<std::string_view, 3>;
    using Four = std::array<std::string_view, 4>;
    std::vector<RotationColumns> found;
    offer(columns, found, PoseConvention::quaternion, Four{"qw", "qx", "qy", "qz"});
    offer(columns, found, PoseConvention::abb, Four{"q1", "q2", "q3", "q4"});
    offer(columns, found, PoseConvention::matrix,
          std::array<std::string_view, 9>{"r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"});
    offer(columns, found, PoseConvention::kuka, Three{"a_deg", "b_deg", "c_deg"});
    offer(columns, found, PoseConvention::kuka, Three{"a", "b", "c"});
    offer(columns, found, PoseConvention::fanuc, Three{"w_deg", "p_deg", "r_deg"});
    offer(columns, found, PoseConvention::fanuc, Three{"w", "p", "r"});
    const std::string known = "qw,qx,qy,qz; q1,q2,q3,q4 (ABB); r11 to r33; a,b,c (KUKA); w,p,r (FANUC)";
    if (found.empty()) {
        columns.refuse("has no columns of a rotation", "", "give one of: " + known);
    }
    if (found.size() > 1) {
        columns.refuse("has a rotation twice",
                       std::string(name_of(found[0].convention)) + ", " + std::string(name_of(found[1].convention)),
                       "keep one of them");
    }
    return found.front();
}

Mat3 nearest_rotation(Mat3 m) {
    // Newton's iteration for the orthogonal factor: quadratic, and the file is near already.
    for (int i = 0; i < 6; ++i) {
        const Mat3 product = m * m.transposed();
        Mat3 factor;
        for (std::size_t r = 0; r < 3; ++r) {
            factor.row[r] = 1.5 * Mat3::identity().row[r] - 0.5 * product.row[r];
        }
        m = factor * m;
    }
    return m;
}

Mat3 read_rotation(const CsvTable& csv, const RowReader& rows, std::size_t row, const RotationColumns& columns) {
    std::vector<double> v;
    for (const std::size_t at : columns.at) {
        v.push_back(csv.number(row, at));
    }
    switch (columns.convention) {
        case PoseConvention::quaternion:
        case PoseConvention::abb: {
            const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
            if (std::abs(length - 1.0) > kNormTolerance) {
                rows.refuse(row, "is no unit quaternion; its length is", about(length),
                            "check which columns the quaternion is in");
            }
            return rotation_of_quaternion({v[0], v[1], v[2], v[3]});
        }
        case PoseConvention::matrix: {
            const Mat3 m{{Vec3{v[0], v[1], v[2]}, Vec3{v[3], v[4], v[5]}, Vec3{v[6], v[7], v[8]}}};
            const double error = orthogonality_error(m);
            if (!(error <= kMatrixTolerance)) {
                rows.refuse(row, "r11 to r33 are no rotation: rows are not orthonormal, by", about(error),
                            "check the columns of the matrix");
            }
            if (m.determinant() < 0.0) {
                rows.refuse(row, "r11 to r33 are left-handed: a mirror, with determinant", about(m.determinant()),
                            "give a right-handed frame: exchange two axes or turn one round");
            }
            return nearest_rotation(m);
        }
        case PoseConvention::kuka: return rotation_of_zyx(v[0] * kDegree, v[1] * kDegree, v[2] * kDegree);
        case PoseConvention::fanuc: return rotation_of_zyx(v[2] * kDegree, v[1] * kDegree, v[0] * kDegree);
    }
    return {};
}

/// One value for all axes, one for each, or none.
struct SigmaColumns {
    std::vector<std::size_t> at;
};

SigmaColumns take_sigma(Columns& columns) {
    if (const auto each = columns.take_all(std::array<std::string_view, 3>{"sigma_x_um", "sigma_y_um", "sigma_z_um"})) {
        return {{each->begin(), each->end()}};
    }
    if (const auto one = columns.take("sigma_um")) {
        return {{*one, *one, *one}};
    }
    return {};
}

Vec3 read_sigma(const CsvTable& csv, const RowReader& rows, std::size_t row, const SigmaColumns& columns) {
    if (columns.at.empty()) {
        return {};
    }
    std::array<double, 3> v{};
    for (std::size_t i = 0; i < 3; ++i) {
        v[i] = csv.number(row, columns.at[i]);
        if (!(v[i] > 0.0 && v[i] <= kLargestSigmaUm)) {
            rows.refuse(row, "sigma must be more than 0 and at most 1000000 um",
                        shortened(csv.text(row, columns.at[i])),
                        "give the noise of a coordinate, 1 sigma, or leave the column out");
        }
    }
    return {v[0] * 1e-6, v[1] * 1e-6, v[2] * 1e-6};
}

[[noreturn]] void refuse_empty(const std::filesystem::path& path, const char* what) {
    throw InputError({.file = path.string(),
                      .problem = "has a header and no rows",
                      .action = std::string("give a row for each ") + what});
}

}  // namespace

std::string_view name_of(PoseConvention convention) noexcept {
    switch (convention) {
        case PoseConvention::quaternion: return "quaternion qw,qx,qy,qz";
        case PoseConvention::abb: return "ABB quaternion q1,q2,q3,q4";
        case PoseConvention::matrix: return "matrix r11..r33";
        case PoseConvention::kuka: return "KUKA A,B,C";
        case PoseConvention::fanuc: return "FANUC W,P,R";
    }
    return "";
}

Mat3 rotation_of_quaternion(const std::array<double, 4>& wxyz) noexcept {
    const double n = 1.0 / std::sqrt(wxyz[0] * wxyz[0] + wxyz[1] * wxyz[1] + wxyz[2] * wxyz[2] + wxyz[3] * wxyz[3]);
    const double w = wxyz[0] * n;
    const double x = wxyz[1] * n;
    const double y = wxyz[2] * n;
    const double z = wxyz[3] * n;
    return {{Vec3{1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)},
             Vec3{2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)},
             Vec3{2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)}}};
}

Mat3 rotation_of_zyx(double z, double y, double x) noexcept {
    const double cz = std::cos(z);
    const double sz = std::sin(z);
    const double cy = std::cos(y);
    const double sy = std::sin(y);
    const double cx = std::cos(x);
    const double sx = std::sin(x);
    return {{Vec3{cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx},
             Vec3{sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx}, Vec3{-sy, cy * sx, cy * cx}}};
}

PoseFile read_poses(const std::filesystem::path& path, const PoseFileWords& words) {
    const CsvTable csv = read_csv(path, words);
    Columns columns(csv);
    const ViewColumns view = take_view(columns);
    const AngleColumn turn = take_angle(columns, {"turn"});
    const AngleColumn tilt = take_angle(columns, {"tilt"});
    const PlaceColumns place = take_place(columns, words);
    const RotationColumns rotation = take_rotation(columns);
    columns.refuse_rest("a file of poses has view or time_s, turn, tilt, x, y, z and one rotation");
    const RowReader rows(csv);
    PoseFile out{.file = path, .convention = rotation.convention, .poses = {}};
    std::set<std::string> seen;
    for (std::size_t row = 0; row < csv.size(); ++row) {
        NamedPose pose{.line = csv.line(row),
                       .view = rows.view(row, view),
                       .time = rows.time(row, view),
                       .turn = rows.angle(row, turn),
                       .tilt = rows.angle(row, tilt),
                       .rotation = read_rotation(csv, rows, row, rotation),
                       .translation = rows.place(row, place)};
        if (!seen.insert(pose.view).second) {
            rows.refuse(row, "view appears twice", shortened(pose.view), "give each view one pose");
        }
        out.poses.push_back(std::move(pose));
    }
    if (out.poses.empty()) {
        refuse_empty(path, "pose");
    }
    return out;
}

MarkerFile read_marker_views(const std::filesystem::path& path, const PoseFileWords& words) {
    const CsvTable csv = read_csv(path, words);
    Columns columns(csv);
    const ViewColumns view = take_view(columns);
    const AngleColumn turn = take_angle(columns, {"turn"});
    const auto id = columns.take("id");
    if (!id) {
        columns.refuse("column is missing", "id", "give each marker its number");
    }
    const PlaceColumns place = take_place(columns, words);
    const SigmaColumns sigma = take_sigma(columns);
    columns.refuse_rest("a file of markers has view or time_s, turn, id, x, y, z, and sigma_um or sigma_x_um to _z_um");
    const RowReader rows(csv);
    MarkerFile out{.file = path, .views = {}};
    for (std::size_t row = 0; row < csv.size(); ++row) {
        // A file of markers without views is one cloud.
        const std::string name = view.view || view.time ? rows.view(row, view) : std::string("1");
        auto at = std::ranges::find(out.views, name, &MarkerView::view);
        if (at == out.views.end()) {
            out.views.push_back({.line = csv.line(row),
                                 .view = name,
                                 .time = rows.time(row, view),
                                 .turn = rows.angle(row, turn),
                                 .markers = {}});
            at = std::prev(out.views.end());
        } else if (rows.angle(row, turn) != at->turn) {
            rows.refuse(row, "turn differs within view " + shortened(name), about(*rows.angle(row, turn)),
                        "give all markers of a view one angle");
        }
        const SeenMarker marker{.line = csv.line(row),
                                .id = csv.integer(row, *id),
                                .place = rows.place(row, place),
                                .sigma = read_sigma(csv, rows, row, sigma)};
        if (std::ranges::find(at->markers, marker.id, &SeenMarker::id) != at->markers.end()) {
            rows.refuse(row, "marker appears twice in view " + shortened(name), std::to_string(marker.id),
                        "keep one of them");
        }
        at->markers.push_back(marker);
    }
    if (out.views.empty()) {
        refuse_empty(path, "marker");
    }
    return out;
}

bool holds_markers(const std::filesystem::path& path, const PoseFileWords& words) {
    const CsvTable csv = read_csv(path, words);
    return Columns(csv).take("id").has_value();
}

}  // namespace sc::host
