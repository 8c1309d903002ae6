// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "host/verification/svg.hpp"
#include "host/verification/table_check.hpp"

namespace sc::host {

namespace {

constexpr double kEnlarged = 500.0;
constexpr double kPanel = 460.0;
constexpr double kInset = 52.0;
constexpr double kTop = 84.0;
constexpr double kHead = 48.0;
constexpr double kGap = 16.0;

struct Box {
    double x0 = 1e9, x1 = -1e9, z0 = 1e9, z1 = -1e9;
    void take(double x, double z) {
        x0 = std::min(x0, x);
        x1 = std::max(x1, x);
        z0 = std::min(z0, z);
        z1 = std::max(z1, z);
    }
    [[nodiscard]] double size() const { return std::max({x1 - x0, z1 - z0, 1.0}); }
};

/// Panel of one face. Seen from the laser, x grows to the left.
void draw_face(Svg& svg, const VerificationTable& table, const TableFace& face, double left, double top) {
    Box box;
    for (const TableRow& row : table.rows) {
        if (row.face_deg == face.face_deg) {
            const Vec3 d = row.measured.v - row.truth.v;
            box.take(1e3 * row.truth.v.x, 1e3 * row.truth.v.z);
            box.take(1e3 * (row.truth.v.x + kEnlarged * d.x), 1e3 * (row.truth.v.z + kEnlarged * d.z));
        }
    }
    const double scale = (kPanel - 2.0 * kInset) / box.size();
    const double middle_x = 0.5 * (box.x0 + box.x1);
    const double middle_z = 0.5 * (box.z0 + box.z1);
    const auto px = [&](double x) { return left + 0.5 * kPanel + scale * (middle_x - x); };
    const auto pz = [&](double z) { return top + kHead + 0.5 * (kPanel - kHead) + scale * (middle_z - z); };
    svg.rect(left, top, kPanel, kPanel, "panel");
    const DeviationFigures& f = face.figures;
    svg.text(left + 12, top + 22, fmt::format("face {:.6g} deg", face.face_deg), "head");
    svg.text(left + 12, top + 40,
             fmt::format("rms {:.3f} {:.3f} {:.3f}, largest {:+.3f} {:+.3f} {:+.3f} mm (x y z); 3-D {:.3f}, {:.3f}",
                         1e3 * f.rms.x, 1e3 * f.rms.y, 1e3 * f.rms.z, 1e3 * f.largest.x, 1e3 * f.largest.y,
                         1e3 * f.largest.z, 1e3 * f.rms_3d, 1e3 * f.max_3d),
             "small");
    for (const TableRow& row : table.rows) {
        if (row.face_deg != face.face_deg) {
            continue;
        }
        const Vec3 d = row.measured.v - row.truth.v;
        const double x = px(1e3 * row.truth.v.x);
        const double z = pz(1e3 * row.truth.v.z);
        svg.open_group(
            fmt::format("marker {}: dx {:+.3f}, dy {:+.3f}, dz {:+.3f} mm", row.no, 1e3 * d.x, 1e3 * d.y, 1e3 * d.z));
        svg.line(x - 4, z, x + 4, z, "burn");
        svg.line(x, z - 4, x, z + 4, "burn");
        svg.arrow(x, z, px(1e3 * (row.truth.v.x + kEnlarged * d.x)), pz(1e3 * (row.truth.v.z + kEnlarged * d.z)),
                  "arrow");
        svg.line(x + 9, z, x + 9, z - scale * kEnlarged * 1e3 * d.y, "ly");
        svg.text(x + 12, z + 12, std::to_string(row.no), "no");
        svg.close_group();
    }
}

/// The warnings, broken at blanks to `width` characters.
std::vector<std::string> lines_of(const TableAssessment& assessment, std::size_t width) {
    std::vector<std::string> out;
    for (const TableWarning& warning : assessment.warnings) {
        std::string rest = fmt::format("{}: {}", name_of(warning.finding), warning.text);
        while (rest.size() > width) {
            const std::size_t blank = rest.rfind(' ', width);
            const std::size_t cut = blank == std::string::npos || blank < width / 2 ? width : blank;
            out.push_back(rest.substr(0, cut));
            rest = "    " + rest.substr(cut == blank ? cut + 1 : cut);
        }
        out.push_back(rest);
    }
    return out;
}

}  // namespace

std::string table_svg(const VerificationTable& table, const TableAssessment& assessment) {
    const std::size_t columns = assessment.faces.size() > 1 ? 2 : 1;
    const std::size_t rows = (assessment.faces.size() + columns - 1) / columns;
    const double width = std::max(static_cast<double>(columns) * (kPanel + kGap) + kGap, 640.0);
    const std::vector<std::string> lines = lines_of(assessment, static_cast<std::size_t>(width / 6.6));
    const double notes = kTop + static_cast<double>(rows) * (kPanel + kGap);
    Svg svg(width, notes + 20.0 * static_cast<double>(lines.size()) + kGap);
    svg.rect(0, 0, width, notes + 20.0 * static_cast<double>(lines.size()) + kGap, "page");
    svg.text(kGap, 30, table.file.filename().string() + ": measured less true", "title");
    svg.text(kGap, 52,
             fmt::format("{} points, rms 3-D {:.3f} mm, largest {:.3f} mm, {:.3f} mm after a fit of each face",
                         assessment.all.points, 1e3 * assessment.all.rms_3d, 1e3 * assessment.all.max_3d,
                         1e3 * assessment.pooled_3d),
             "small");
    svg.text(kGap, 70, fmt::format("seen from the laser; arrows: x and z, bars: y, {:.0f} times enlarged", kEnlarged),
             "small");
    for (std::size_t i = 0; i < assessment.faces.size(); ++i) {
        const std::size_t row = i / columns;
        draw_face(svg, table, assessment.faces[i], kGap + static_cast<double>(i % columns) * (kPanel + kGap),
                  kTop + static_cast<double>(row) * (kPanel + kGap));
    }
    double y = notes + 8.0;
    for (const std::string& line : lines) {
        svg.text(kGap, y, line, "small");
        y += 20.0;
    }
    return svg.finish();
}

}  // namespace sc::host
