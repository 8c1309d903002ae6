// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/inspection_drawings.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr double kMm = 1e3;
constexpr std::array<const char*, 6> kSides{"+X", "-X", "+Y", "-Y", "+Z", "-Z"};

std::string num(double value) { return fixed(value, 2); }

std::string rect(double x, double y, double width, double height, const char* style) {
    return "<rect x=\"" + num(x) + "\" y=\"" + num(y) + "\" width=\"" + num(width) + "\" height=\"" + num(height) +
           "\" class=\"" + style + "\"/>";
}
std::string label(double x, double y, const std::string& text, const char* anchor = "middle") {
    return "<text x=\"" + num(x) + "\" y=\"" + num(y) + "\" text-anchor=\"" + anchor + "\">" + escaped(text) +
           "</text>";
}
std::string stroke(double x1, double y1, double x2, double y2, const char* style) {
    return "<line x1=\"" + num(x1) + "\" y1=\"" + num(y1) + "\" x2=\"" + num(x2) + "\" y2=\"" + num(y2) +
           "\" class=\"" + style + "\"/>";
}
std::string svg(double width, double height, const std::string& body) {
    return "<svg viewBox=\"0 0 " + num(width) + " " + num(height) + "\" width=\"" + num(width) + "\" role=\"img\">" +
           body + "</svg>";
}

/// Coordinates within a plane, and the box about what is drawn.
class Flat {
public:
    explicit Flat(const Plane& plane) {
        const Vec3 n = plane.normal;
        const Vec3 other = std::abs(n.z) < 0.8 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
        const Vec3 across = cross(other, n);
        u_ = (1.0 / norm(across)) * across;
        v_ = cross(n, u_);
    }
    void take(const Vec3& p) {
        const auto [x, y] = raw(p);
        low_ = {std::min(low_[0], x), std::min(low_[1], y)};
        high_ = {std::max(high_[0], x), std::max(high_[1], y)};
    }
    [[nodiscard]] double scale() const { return kWide / std::max(high_[0] - low_[0], 1e-6); }
    [[nodiscard]] std::array<double, 2> at(const Vec3& p) const {
        const auto [x, y] = raw(p);
        return {20.0 + scale() * (x - low_[0]), 20.0 + scale() * (high_[1] - y)};
    }
    [[nodiscard]] double height() const { return 40.0 + scale() * (high_[1] - low_[1]); }
    static constexpr double kWide = 520.0;

private:
    [[nodiscard]] std::array<double, 2> raw(const Vec3& p) const { return {dot(p, u_), dot(p, v_)}; }
    Vec3 u_;
    Vec3 v_;
    std::array<double, 2> low_{1e9, 1e9};
    std::array<double, 2> high_{-1e9, -1e9};
};

std::string path_of(const Flat& flat, std::span<const LinePlace> places, bool closed) {
    std::string out = "<path class=\"run\" d=\"";
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto [x, y] = flat.at(places[i].place);
        out += (i == 0 ? "M" : "L") + num(x) + " " + num(y);
    }
    return out + (closed ? "Z\"/>" : "\"/>");
}

}  // namespace

std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            case '&': out += "&amp;"; break;
            case '"': out += "&quot;"; break;
            default: out += c;
        }
    }
    return out;
}

std::string histogram_svg(const FaceAllowance& before, const FaceAllowance* after) {
    const FaceAllowance& shown = after != nullptr ? *after : before;
    std::size_t most = 1;
    for (const std::size_t n : shown.histogram) {
        most = std::max(most, n);
    }
    std::string body;
    constexpr double kBar = 11.0;
    for (std::size_t i = 0; i < kHistogram; ++i) {
        const double middle = shown.histogram_low + (static_cast<double>(i) + 0.5) * shown.histogram_width;
        const double height = 70.0 * static_cast<double>(shown.histogram[i]) / static_cast<double>(most);
        body += rect(10.0 + kBar * static_cast<double>(i), 80.0 - height, kBar - 1.0, height,
                     middle < shown.least_asked ? "lack" : "more");
    }
    const double width = kBar * static_cast<double>(kHistogram);
    const double high = shown.histogram_low + static_cast<double>(kHistogram) * shown.histogram_width;
    body += stroke(10, 80, 10 + width, 80, "axis") + label(10, 94, num(kMm * shown.histogram_low), "start") +
            label(10 + width, 94, num(kMm * high) + " mm", "end");
    if (shown.histogram_width > 0.0 && shown.least_asked > shown.histogram_low && shown.least_asked < high) {
        const double x = 10.0 + width * (shown.least_asked - shown.histogram_low) / (high - shown.histogram_low);
        body += stroke(x, 5, x, 80, "asked") + label(x, 94, num(kMm * shown.least_asked));
    }
    return "<figure><figcaption>" + escaped(shown.id) + "</figcaption>" + svg(width + 20.0, 100, body) + "</figure>";
}

std::string sides_svg(const AllowanceReport& before, const AllowanceReport* after) {
    double most = 1e-6;
    for (const AllowanceReport* report : {&before, after}) {
        for (std::size_t i = 0; report != nullptr && i < 6; ++i) {
            most = std::max(most, report->sides[i / 2][i % 2].mean);
        }
    }
    std::string body;
    double x = 40.0;
    for (std::size_t i = 0; i < 6; ++i) {
        const auto bar = [&](const AllowanceReport& report, double at, const char* style) {
            const Side& side = report.sides[i / 2][i % 2];
            const double height = 110.0 * std::max(side.mean, 0.0) / most;
            return side.count == 0 ? std::string()
                                   : rect(at, 130.0 - height, 26, height, style) +
                                         label(at + 13, 126.0 - height, fixed(kMm * side.mean, 3));
        };
        if (before.sides[i / 2][i % 2].count > 0) {
            body += bar(before, x, "before");
            body += after != nullptr ? bar(*after, x + 30.0, "after") : std::string();
            body += label(x + 28, 146, kSides[i]);
            x += i % 2 == 0 ? 76.0 : 100.0;
        }
    }
    return svg(x, 150, stroke(30, 130, x - 20.0, 130, "axis") + body);
}

std::string section_svg(const DatumLine& line, const TriangleMesh& mesh) {
    const std::vector<SectionPiece> pieces = section(mesh, line.plane);
    Flat flat(line.plane);
    for (const SectionPiece& piece : pieces) {
        flat.take(piece.from);
    }
    for (const LineRun& run : line.cut.runs) {
        for (const LinePlace& at : run.places) {
            flat.take(at.place);
        }
    }
    std::string body = "<path class=\"cad\" d=\"";
    for (const SectionPiece& piece : pieces) {
        const auto [x1, y1] = flat.at(piece.from);
        const auto [x2, y2] = flat.at(piece.to);
        body += "M" + num(x1) + " " + num(y1) + "L" + num(x2) + " " + num(y2);
    }
    body += "\"/>";
    for (const LineRun& run : line.cut.runs) {
        body += path_of(flat, run.places, run.closed);
    }
    for (const LineGap& gap : line.cut.gaps) {
        const auto [x1, y1] = flat.at(gap.from);
        const auto [x2, y2] = flat.at(gap.to);
        body += stroke(x1, y1, x2, y2, "gap");
    }
    const double ten = 0.01 * flat.scale();
    body += stroke(20, flat.height() - 6, 20 + ten, flat.height() - 6, "axis") +
            label(26 + ten, flat.height() - 2, "10 mm", "start");
    return "<figure><figcaption>datum " + escaped(line.id) + ": " + fixed(kMm * line.cut.length, 1) + " mm, " +
           std::to_string(line.cut.gaps.size()) + " gaps</figcaption>" + svg(Flat::kWide + 40.0, flat.height(), body) +
           "</figure>";
}

}  // namespace sc::host
