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
constexpr const char* kStyle =
    "<style>text{font:14px sans-serif;fill:#1d2733}.h{font:600 16px sans-serif}.f{font:600 26px sans-serif}"
    ".s{fill:#5b6876;font-size:12px}.r{stroke:#3a6ea5;stroke-width:4;fill:none}.o{stroke:#c4562b;stroke-width:4}"
    ".b{stroke:#d33;stroke-width:1.2;stroke-dasharray:5 4}.d{fill:#d33}.n{fill:#fff;font:600 12px sans-serif}"
    ".g{stroke:#d7dde3;stroke-width:1;fill:none}.p{fill:#f6f8fa;stroke:#d7dde3}.a{stroke:#1d2733;stroke-width:1.5;"
    "fill:none}.bad{fill:#b3261e;font:600 22px sans-serif}</style>";

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&': out += "&amp;"; break;
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            default: out += c;
        }
    }
    return out;
}

std::string text_at(double x, double y, const char* css, const std::string& text, const char* anchor = "start") {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"{}\" text-anchor=\"{}\">{}</text>\n", x, y, css, anchor,
                       escaped(text));
}

std::string line_at(double x1, double y1, double x2, double y2, const char* css) {
    return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\"/>\n", x1, y1, x2, y2,
                       css);
}

std::string dot_at(double x, double y, const std::string& number) {
    return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"10\" class=\"d\"/>", x, y) +
           text_at(x, y + 4.5, "n", number, "middle");
}

std::string frame(const std::string& body) {
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 900 520\" width=\"900\" height=\"520\">" +
           std::string(kStyle) + "<rect width=\"900\" height=\"520\" fill=\"#fff\"/>\n" + body + "</svg>\n";
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
std::string front_view(const StationResult& r, const Box& box) {
    std::vector<double> y{r.at[0]};
    std::vector<double> z{0.0, r.at[1]};
    for (const Vec3& spot : r.spots) {
        y.push_back(spot.y);
        z.push_back(spot.z);
    }
    const Scale s = fit(box, span_of(y), span_of(z));
    std::string out = fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"6\" class=\"p\"/>\n",
                                  box.left, box.top, box.width, box.height);
    out += text_at(box.left + 12.0, box.top + 22.0, "h", "Front view");
    out += line_at(box.left + 20.0, s.y(0.0), box.left + box.width - 20.0, s.y(0.0), "r");
    out += text_at(box.left + 22.0, s.y(0.0) + 17.0, "s", "reference plane");
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3& a = r.spots[i];
        const Vec3& b = r.spots[(i + 1) % 3];
        out += line_at(s.x(a.y), s.y(a.z), s.x(b.y), s.y(b.z), "g");
    }
    for (std::size_t i = 0; i < 3; ++i) {
        out += dot_at(s.x(r.spots[i].y), s.y(r.spots[i].z), std::to_string(i + 1));
        out += text_at(s.x(r.spots[i].y), s.y(r.spots[i].z) + 26.0, "s", fmt::format("{:.2f} mm", r.reading[i] * kMm),
                       "middle");
    }
    return out;
}

/// Seen along −y of r: x (along the beams) to the right, z up; both planes are seen edge on.
std::string side_view(const StationResult& r, const Box& box) {
    // The face's edge in this plane, through (distance, at).
    const double tan_up = -r.normal.z / r.normal.x;  // dx/dz of the face
    const auto face_x = [&](double z) { return r.distance + tan_up * (z - r.at[1]); };
    const double top = std::max({r.spots[0].z, r.spots[1].z, r.spots[2].z}) + 0.02;
    const std::array x{std::min(0.0, face_x(0.0)), std::max({face_x(0.0), face_x(top), 0.05})};
    const Scale s = fit(box, x, {0.0, top});
    std::string out = fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"6\" class=\"p\"/>\n",
                                  box.left, box.top, box.width, box.height);
    out += text_at(box.left + 12.0, box.top + 22.0, "h", "Top view");
    out += line_at(s.x(x[0]) - 12.0, s.y(0.0), s.x(x[1]) + 12.0, s.y(0.0), "r");
    out += line_at(s.x(face_x(0.0)), s.y(0.0), s.x(face_x(top)), s.y(top), "o");
    for (std::size_t i = 0; i < 3; ++i) {
        out += line_at(s.x(0.0), s.y(r.spots[i].z), s.x(r.spots[i].x), s.y(r.spots[i].z), "b");
        out += dot_at(s.x(r.spots[i].x), s.y(r.spots[i].z), std::to_string(i + 1));
    }
    out += text_at(s.x(x[0]), s.y(0.0) + 18.0, "s", "reference plane");
    out += text_at(s.x(face_x(top)) - 8.0, s.y(top) - 8.0, "s", "object plane", "end");
    // The angle, as an arc about the corner.
    const double radius = 46.0;
    const double cx = s.x(face_x(0.0));
    const double cy = s.y(0.0);
    const double end = std::numbers::pi - r.about_y;
    out += fmt::format("<path d=\"M{:.1f} {:.1f} A{r} {r} 0 0 1 {:.1f} {:.1f}\" class=\"a\"/>\n", cx - radius, cy,
                       cx + radius * std::cos(end), cy - radius * std::sin(end), fmt::arg("r", radius));
    out += text_at(cx - radius - 8.0, cy - 14.0, "h", fmt::format("{:.2f}\u00b0", r.angle / kDegree), "end");
    return out;
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

std::string station_svg(const StationResult& result, const Correction* correction) {
    std::string body = text_at(24.0, 36.0, "f", "Station " + result.id);
    if (result.rail) {
        body += text_at(876.0, 36.0, "s", fmt::format("rail {:.1f} mm", *result.rail * kMm), "end");
    }
    body += front_view(result, {24.0, 56.0, 300.0, 300.0});
    body += side_view(result, {340.0, 56.0, 536.0, 300.0});
    double x = 24.0;
    for (const FigureLine& figure : figures_of(result)) {
        body += text_at(x, 388.0, "s", figure.name);
        body += text_at(x, 416.0, "f", figure.value);
        body += text_at(x, 438.0, "s", figure.uncertainty + " (95 %)");
        x += 218.0;
    }
    body += text_at(24.0, 470.0, "s",
                    fmt::format("{} readings, noise {:.3f} mm{}, {} left out", result.used, result.noise * kMm,
                                result.noisier ? " (more than calibrated)" : "", result.left_out));
    if (correction != nullptr) {
        body += text_at(24.0, 498.0, "h", correction_text(*correction));
    }
    return frame(body);
}

std::string refusal_svg(const std::string& station, const StationRefusal& refusal) {
    std::string body = text_at(24.0, 36.0, "f", "Station " + station);
    body += text_at(24.0, 120.0, "bad", "no figures: " + std::string(name_of(refusal.problem)));
    double y = 160.0;
    for (std::size_t at = 0; at < refusal.text.size();) {
        const std::size_t end = std::min(refusal.text.find(' ', at + 95), refusal.text.size());
        body += text_at(24.0, y, "h", refusal.text.substr(at, end - at));
        at = end == refusal.text.size() ? end : end + 1;
        y += 26.0;
    }
    return frame(body);
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
