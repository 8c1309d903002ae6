// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "host/path/face_places.hpp"
#include "host/verification/report.hpp"
#include "host/verification/svg.hpp"

namespace sc::host {

namespace {

constexpr double kArrowFactor = 1000.0;
constexpr double kPanelWidth = 620.0;
constexpr double kHeadHeight = 78.0;
constexpr double kFootHeight = 44.0;
constexpr double kPictureHeight = 460.0;
constexpr double kPanelHeight = kHeadHeight + kPictureHeight + kFootHeight;
constexpr double kGap = 18.0;
constexpr double kTop = 68.0;
constexpr double kInset = 46.0;  ///< between panel and drawing, for the numbers on the grid

/// From millimetres on the face to the picture: the same scale both ways, the drawing centred. Seen from the laser, x
/// grows to the left.
class FaceMap {
public:
    FaceMap(double left, double top, const Flat& least, const Flat& most) : least_(least), most_(most) {
        const double width = kPanelWidth - 2.0 * kInset;
        const double height = kPictureHeight - kInset;
        const Flat size = most - least;
        scale_ = std::min(width / size.x, height / size.z);
        x0_ = left + kInset + 0.5 * (width - scale_ * size.x);
        y0_ = top + kHeadHeight + 0.5 * (height - scale_ * size.z);
    }
    [[nodiscard]] double x(double mm) const { return x0_ + scale_ * (most_.x - mm); }
    [[nodiscard]] double y(double mm) const { return y0_ + scale_ * (most_.z - mm); }
    [[nodiscard]] double scale() const { return scale_; }
    [[nodiscard]] const Flat& least() const { return least_; }
    [[nodiscard]] const Flat& most() const { return most_; }

private:
    Flat least_;
    Flat most_;
    double scale_ = 1.0;
    double x0_ = 0.0;
    double y0_ = 0.0;
};

Flat in_mm(const Vec3& v) { return {1e3 * v.x, 1e3 * v.z}; }
Flat in_mm(const Flat& v) { return 1e3 * v; }
Flat tip_of(const PointAccuracy& point) { return in_mm(point.found.v) + kArrowFactor * in_mm(point.deviation); }

/// All that is drawn on a face, so that nothing is cut off.
std::vector<Flat> drawn_places(const FaceAccuracy& face, const BurnFindings& burns) {
    std::vector<Flat> places;
    for (const Stroke& stroke : burns.strokes) {
        if (same_face(stroke.face_deg, face.face_deg)) {
            places.push_back(in_mm(stroke.line.at(stroke.line.first)));
            places.push_back(in_mm(stroke.line.at(stroke.line.last)));
        }
    }
    for (const PointAccuracy& point : face.points) {
        places.push_back(in_mm(point.found.v));
        places.push_back(tip_of(point));
    }
    return places;
}

FaceMap map_of(double left, double top, const std::vector<Flat>& places) {
    constexpr double kMargin = 8.0;
    Flat least{-50.0, -50.0};
    Flat most{50.0, 50.0};
    if (!places.empty()) {
        least = most = places.front();
    }
    for (const Flat& p : places) {
        least = {std::min(least.x, p.x), std::min(least.z, p.z)};
        most = {std::max(most.x, p.x), std::max(most.z, p.z)};
    }
    return {left, top, least - Flat{kMargin, kMargin}, most + Flat{kMargin, kMargin}};
}

std::vector<double> multiples(double step, double least, double most) {
    std::vector<double> out;
    const auto first = static_cast<int>(std::ceil(least / step));
    const auto last = static_cast<int>(std::floor(most / step));
    for (int i = first; i <= last; ++i) {
        out.push_back(step * i);
    }
    return out;
}

void draw_grid(Svg& svg, const FaceMap& map) {
    const double width = std::max(map.most().x - map.least().x, map.most().z - map.least().z);
    const double step = width > 120.0 ? 50.0 : (width > 40.0 ? 10.0 : 5.0);
    for (const double x : multiples(step, map.least().x, map.most().x)) {
        svg.line(map.x(x), map.y(map.least().z), map.x(x), map.y(map.most().z), "grid");
        svg.text(map.x(x), map.y(map.least().z) + 13.0, fmt::format("{:.0f}", x), "small", "middle");
    }
    for (const double z : multiples(step, map.least().z, map.most().z)) {
        svg.line(map.x(map.least().x), map.y(z), map.x(map.most().x), map.y(z), "grid");
        svg.text(map.x(map.most().x) - 5.0, map.y(z) + 4.0, fmt::format("{:.0f}", z), "small", "end");
    }
}

void draw_burns(Svg& svg, const FaceMap& map, const FaceAccuracy& face, const Report& report) {
    for (std::size_t i = 0; i < report.burns.strokes.size(); ++i) {
        const Stroke& stroke = report.burns.strokes[i];
        if (!same_face(stroke.face_deg, face.face_deg)) {
            continue;
        }
        const bool is_line = std::ranges::any_of(report.burns.lines, [i](const FoundLine& l) { return l.stroke == i; });
        const Flat from = in_mm(stroke.line.at(stroke.line.first));
        const Flat to = in_mm(stroke.line.at(stroke.line.last));
        svg.line(map.x(from.x), map.y(from.z), map.x(to.x), map.y(to.z), is_line ? "datum" : "burn");
    }
}

/// The number stands on the side that the arrow does not take.
void draw_point(Svg& svg, const FaceMap& map, const PointAccuracy& point) {
    const Flat at = in_mm(point.found.v);
    const Flat tip = tip_of(point);
    svg.open_group(fmt::format("marker {}: deviation x {:.3f}, y {:.3f}, z {:.3f} mm", point.no,
                               1e3 * point.deviation.x, 1e3 * point.deviation.y, 1e3 * point.deviation.z));
    svg.arrow(map.x(at.x), map.y(at.z), map.x(tip.x), map.y(tip.z), "arrow");
    const double side = map.x(tip.x) > map.x(at.x) ? -1.0 : 1.0;
    const double level = tip.z > at.z ? 13.0 : -6.0;
    svg.text(map.x(at.x) + 7.0 * side, map.y(at.z) + level, fmt::format("{}", point.no), "no",
             side > 0.0 ? "start" : "end");
    svg.close_group();
}

void draw_head(Svg& svg, double left, double top, const FaceAccuracy& face) {
    svg.text(left + 14.0, top + 24.0, fmt::format("{:g}° surface", face.face_deg), "head");
    const Vec3 max = 1e3 * face.found.max;
    const Vec3 rms = 1e3 * face.found.rms;
    svg.text(left + 14.0, top + 43.0,
             fmt::format("{} crosses found; deviation from the true places (mm):", face.points.size()), "small");
    svg.text(left + 14.0, top + 58.0,
             fmt::format("max x {:.3f}, y {:.3f}, z {:.3f}; rms x {:.3f}, y {:.3f}, z {:.3f}", max.x, max.y, max.z,
                         rms.x, rms.y, rms.z),
             "small");
    if (!face.not_found.empty()) {
        svg.text(left + kPanelWidth - 14.0, top + 24.0,
                 fmt::format("not found: marker {}", fmt::join(face.not_found, ", ")), "no", "end");
    }
}

/// One length serves both: what it is on the face, and the deviation whose arrow is as long.
void draw_scale_bar(Svg& svg, double left, double top, const FaceMap& map) {
    const double y = top + kPanelHeight - 16.0;
    const double wide = 120.0 / map.scale();
    const double mm = wide > 50.0 ? 50.0 : (wide > 20.0 ? 20.0 : (wide > 10.0 ? 10.0 : 1.0));
    const double x1 = left + 14.0;
    const double x2 = x1 + map.scale() * mm;
    svg.line(x1, y, x2, y, "bar");
    svg.line(x1, y - 4.0, x1, y + 4.0, "bar");
    svg.line(x2, y - 4.0, x2, y + 4.0, "bar");
    svg.text(x2 + 10.0, y + 4.0,
             fmt::format("{:g} mm on the face; as an arrow, {:g} mm of deviation (found - true, x and z, × {:.0f})", mm,
                         mm / kArrowFactor, kArrowFactor),
             "small");
}

void draw_face(Svg& svg, double left, double top, const FaceAccuracy& face, const Report& report) {
    svg.rect(left, top, kPanelWidth, kPanelHeight, "panel");
    const FaceMap map = map_of(left, top, drawn_places(face, report.burns));
    draw_grid(svg, map);
    draw_burns(svg, map, face, report);
    for (const PointAccuracy& point : face.points) {
        draw_point(svg, map, point);
    }
    for (const Point<frame::H>& place : face.unmatched) {
        svg.circle(map.x(1e3 * place.v.x), map.y(1e3 * place.v.z), 9.0, "lost");
    }
    draw_head(svg, left, top, face);
    draw_scale_bar(svg, left, top, map);
}

}  // namespace

std::string report_svg(const Report& report) {
    const std::vector<FaceAccuracy>& faces = report.accuracy.faces;
    const std::size_t columns = faces.size() > 1 ? 2 : 1;
    const std::size_t rows = std::max<std::size_t>(1, (faces.size() + columns - 1) / columns);
    const double width = kGap + static_cast<double>(columns) * (kPanelWidth + kGap);
    const double height = kTop + static_cast<double>(rows) * (kPanelHeight + kGap);
    Svg svg(width, height);
    svg.rect(0.0, 0.0, width, height, "page");
    svg.text(kGap, 32.0,
             fmt::format("{}: what was burnt, as seen from the laser (x grows to the left, z up; mm)", report.run.job),
             "title");
    svg.text(
        kGap, 52.0,
        "Black: crosses, with their markers' numbers. Blue: datum lines. Red: deviation, found - true, in x and z.",
        "small");
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const double left = kGap + static_cast<double>(i % columns) * (kPanelWidth + kGap);
        const std::size_t row = i / columns;
        const double top = kTop + static_cast<double>(row) * (kPanelHeight + kGap);
        draw_face(svg, left, top, faces[i], report);
    }
    return svg.finish();
}

}  // namespace sc::host
