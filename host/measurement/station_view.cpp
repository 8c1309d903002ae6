// SPDX-License-Identifier: Apache-2.0
#include "host/measurement/station_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

namespace sc::host {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMm = 1e3;
void text_at(Drawing& d, double x, double y, Font font, std::string text, Anchor anchor = Anchor::start) {
    d.shapes.emplace_back(Drawing::Text{{x, y}, font, anchor, std::move(text)});
}

void line_at(Drawing& d, double x1, double y1, double x2, double y2, Stroke stroke) {
    d.shapes.emplace_back(Drawing::Line{{x1, y1}, {x2, y2}, stroke});
}

void dot_at(Drawing& d, double x, double y, const std::string& number) {
    d.shapes.emplace_back(Drawing::Disc{{x, y}, 10.0});
    text_at(d, x, y + 4.5, Font::number, number, Anchor::middle);
}

Drawing sheet() {
    Drawing d;
    d.width = 900;
    d.height = 520;
    return d;
}

struct Box {
    double left;
    double top;
    double width;
    double height;
};

/// Metres to the box, the same scale both ways.
struct Scale {
    double factor = 1.0;
    double x0 = 0.0;
    double y0 = 0.0;
    [[nodiscard]] double x(double v) const { return x0 + factor * v; }
    [[nodiscard]] double y(double v) const { return y0 - factor * v; }
};

Scale fit(const Box& box, std::array<double, 2> x, std::array<double, 2> y) {
    const double room = 34.0;
    const double factor = std::min((box.width - 2.0 * room) / std::max(x[1] - x[0], 1e-3),
                                   (box.height - 2.0 * room) / std::max(y[1] - y[0], 1e-3));
    return {factor, box.left + 0.5 * box.width - factor * 0.5 * (x[0] + x[1]),
            box.top + 0.5 * box.height + factor * 0.5 * (y[0] + y[1])};
}

std::array<double, 2> span_of(const std::vector<double>& values) {
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    return {*least, *most};
}

/// Seen along the beams: y of r to the right, z up.
void front_view(Drawing& d, const StationResult& r, const Box& box) {
    std::vector<double> y{r.at[0]};
    std::vector<double> z{0.0, r.at[1]};
    for (const Vec3& spot : r.spots) {
        y.push_back(spot.y);
        z.push_back(spot.z);
    }
    const Scale s = fit(box, span_of(y), span_of(z));
    d.shapes.emplace_back(Drawing::Panel{{box.left, box.top}, {box.width, box.height}});
    text_at(d, box.left + 12.0, box.top + 22.0, Font::heading, "Front view");
    line_at(d, box.left + 20.0, s.y(0.0), box.left + box.width - 20.0, s.y(0.0), Stroke::reference);
    text_at(d, box.left + 22.0, s.y(0.0) + 17.0, Font::small, "reference plane");
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3& a = r.spots[i];
        const Vec3& b = r.spots[(i + 1) % 3];
        line_at(d, s.x(a.y), s.y(a.z), s.x(b.y), s.y(b.z), Stroke::guide);
    }
    for (std::size_t i = 0; i < 3; ++i) {
        dot_at(d, s.x(r.spots[i].y), s.y(r.spots[i].z), std::to_string(i + 1));
        text_at(d, s.x(r.spots[i].y), s.y(r.spots[i].z) + 26.0, Font::small,
                fmt::format("{:.2f} mm", r.reading[i] * kMm), Anchor::middle);
    }
}

/// Seen along −y of r: x (along the beams) to the right, z up; both planes are seen edge on.
void side_view(Drawing& d, const StationResult& r, const Box& box) {
    // The face's edge in this plane, through (distance, at).
    const double tan_up = -r.normal.z / r.normal.x;  // dx/dz of the face
    const auto face_x = [&](double z) { return r.distance + tan_up * (z - r.at[1]); };
    const double top = std::max({r.spots[0].z, r.spots[1].z, r.spots[2].z}) + 0.02;
    const std::array x{std::min(0.0, face_x(0.0)), std::max({face_x(0.0), face_x(top), 0.05})};
    const Scale s = fit(box, x, {0.0, top});
    d.shapes.emplace_back(Drawing::Panel{{box.left, box.top}, {box.width, box.height}});
    text_at(d, box.left + 12.0, box.top + 22.0, Font::heading, "Top view");
    line_at(d, s.x(x[0]) - 12.0, s.y(0.0), s.x(x[1]) + 12.0, s.y(0.0), Stroke::reference);
    line_at(d, s.x(face_x(0.0)), s.y(0.0), s.x(face_x(top)), s.y(top), Stroke::object);
    for (std::size_t i = 0; i < 3; ++i) {
        line_at(d, s.x(0.0), s.y(r.spots[i].z), s.x(r.spots[i].x), s.y(r.spots[i].z), Stroke::beam);
        dot_at(d, s.x(r.spots[i].x), s.y(r.spots[i].z), std::to_string(i + 1));
    }
    text_at(d, s.x(x[0]), s.y(0.0) + 18.0, Font::small, "reference plane");
    text_at(d, s.x(face_x(top)) - 8.0, s.y(top) - 8.0, Font::small, "object plane", Anchor::end);
    // The angle, as an arc about the corner.
    const double radius = 46.0;
    const double cx = s.x(face_x(0.0));
    const double cy = s.y(0.0);
    d.shapes.emplace_back(Drawing::Arc{{cx, cy}, radius, {std::numbers::pi, std::numbers::pi - r.about_y}});
    text_at(d, cx - radius - 8.0, cy - 14.0, Font::heading, fmt::format("{:.2f}\u00b0", r.angle / kDegree),
            Anchor::end);
}

struct FigureLine {
    const char* name;
    std::string value;
    std::string uncertainty;
};

std::vector<FigureLine> figures_of(const StationResult& r) {
    const auto degrees = [](const char* name, double value, const UncertaintyParts& sigma) {
        return FigureLine{name, fmt::format("{:.3f} deg", value / kDegree),
                          fmt::format("+- {:.3f}", kCoverage95 * sigma.total() / kDegree)};
    };
    return {degrees("angle", r.angle, r.angle_sigma),
            degrees("about y", r.about_y, r.about_y_sigma),
            degrees("about z (yaw)", r.about_z, r.about_z_sigma),
            {"distance", fmt::format("{:.3f} mm", r.distance * kMm),
             fmt::format("+- {:.3f}", kCoverage95 * r.distance_sigma.total() * kMm)}};
}

}  // namespace

Drawing station_drawing(const StationResult& result, const Correction* correction) {
    Drawing d = sheet();
    text_at(d, 24.0, 36.0, Font::figure, "Station " + result.id);
    if (result.rail) {
        text_at(d, 876.0, 36.0, Font::small, fmt::format("rail {:.1f} mm", *result.rail * kMm), Anchor::end);
    }
    front_view(d, result, {24.0, 56.0, 300.0, 300.0});
    side_view(d, result, {340.0, 56.0, 536.0, 300.0});
    double x = 24.0;
    for (const FigureLine& figure : figures_of(result)) {
        text_at(d, x, 388.0, Font::small, figure.name);
        text_at(d, x, 416.0, Font::figure, figure.value);
        text_at(d, x, 438.0, Font::small, figure.uncertainty + " (95 %)");
        x += 218.0;
    }
    text_at(d, 24.0, 470.0, Font::small,
            fmt::format("{} readings, noise {:.3f} mm{}, {} left out", result.used, result.noise * kMm,
                        result.noisier ? " (more than calibrated)" : "", result.left_out));
    if (correction != nullptr) {
        text_at(d, 24.0, 498.0, Font::heading, correction_text(*correction));
    }
    return d;
}

Drawing refusal_drawing(const std::string& station, const StationRefusal& refusal) {
    Drawing d = sheet();
    text_at(d, 24.0, 36.0, Font::figure, "Station " + station);
    text_at(d, 24.0, 120.0, Font::warning, "no figures: " + std::string(name_of(refusal.problem)));
    double y = 160.0;
    for (std::size_t at = 0; at < refusal.text.size();) {
        const std::size_t end = std::min(refusal.text.find(' ', at + 85), refusal.text.size());
        text_at(d, 24.0, y, Font::heading, refusal.text.substr(at, end - at));
        at = end == refusal.text.size() ? end : end + 1;
        y += 26.0;
    }
    return d;
}

std::string station_page(const StationResult& result, const Correction* correction) {
    constexpr int kWidth = 36;
    constexpr int kHeight = 14;
    using Canvas = std::vector<std::string>;
    Canvas front(kHeight, std::string(kWidth, ' '));
    Canvas side(kHeight, std::string(kWidth, ' '));
    double top = 0.02;
    double reach = 0.02;
    for (const Vec3& spot : result.spots) {
        top = std::max(top, spot.z * 1.15);
        reach = std::max(reach, std::abs(spot.y - result.at[0]) * 1.2);
    }
    const auto put = [&](Canvas& canvas, double x, double y, char c) {
        const int column = static_cast<int>(std::lround(x * (kWidth - 1)));
        const int row = kHeight - 1 - static_cast<int>(std::lround(y * (kHeight - 1)));
        if (column >= 0 && column < kWidth && row >= 0 && row < kHeight) {
            canvas[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] = c;
        }
    };
    const double tan_up = -result.normal.z / result.normal.x;
    const auto face_x = [&](double z) { return result.distance + tan_up * (z - result.at[1]); };
    const double furthest = 1.05 * std::max({face_x(0.0), face_x(top), 0.01});
    for (int k = 0; k < kWidth; ++k) {
        put(front, static_cast<double>(k) / (kWidth - 1), 0.0, '=');
        put(side, static_cast<double>(k) / (kWidth - 1), 0.0, '=');
    }
    for (int k = 0; k < 4 * kHeight; ++k) {
        const double z = top * k / (4.0 * kHeight);
        put(side, face_x(z) / furthest, z / top, '/');
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3& spot = result.spots[i];
        const char number = static_cast<char>('1' + static_cast<int>(i));
        for (int k = 0; k < kWidth; ++k) {
            const double x = furthest * k / (kWidth - 1);
            if (x < spot.x) {
                put(side, x / furthest, spot.z / top, '.');
            }
        }
        put(side, spot.x / furthest, spot.z / top, number);
        put(front, 0.5 + 0.5 * (spot.y - result.at[0]) / reach, spot.z / top, number);
    }
    std::string out = fmt::format("station {:<28} front view | top view, = reference, / object\n", result.id);
    for (std::size_t row = 0; row < front.size(); ++row) {
        out += fmt::format("{} | {}\n", front[row], side[row]);
    }
    for (const FigureLine& figure : figures_of(result)) {
        out += fmt::format("{:<14} {:>14} {} (95 %)\n", figure.name, figure.value, figure.uncertainty);
    }
    if (correction != nullptr) {
        out += correction_text(*correction) + "\n";
    }
    return out;
}

std::string table_head() {
    return fmt::format("{:<14} {:>9} {:>9} {:>8} {:>9} {:>9} {:>10} {:>8}  {}\n", "station", "rail mm", "angle",
                       "+-95%", "about y", "about z", "dist. mm", "+-95%", "what to do");
}

std::string table_row(const StationResult& r, const Correction* correction) {
    return fmt::format("{:<14} {:>9} {:>9.3f} {:>8.3f} {:>9.3f} {:>9.3f} {:>10.3f} {:>8.3f}  {}\n", r.id,
                       r.rail ? fmt::format("{:.1f}", *r.rail * kMm) : std::string("-"), r.angle / kDegree,
                       kCoverage95 * r.angle_sigma.total() / kDegree, r.about_y / kDegree, r.about_z / kDegree,
                       r.distance * kMm, kCoverage95 * r.distance_sigma.total() * kMm,
                       correction != nullptr ? correction_text(*correction) : std::string("-"));
}

}  // namespace sc::host
