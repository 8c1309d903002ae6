// SPDX-License-Identifier: Apache-2.0
#include "host/verification/svg.hpp"

#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace sc::host {

namespace {

constexpr std::string_view kStyle = R"(
text{font-family:"DejaVu Sans","Liberation Sans",Arial,sans-serif;fill:#24313d}
.title{font-size:17px;font-weight:bold}
.head{font-size:14px;font-weight:bold}
.small{font-size:11px;fill:#5b6b79}
.no{font-size:11px;font-weight:bold}
.page{fill:#ffffff}
.panel{fill:#fbfbf9;stroke:#c9d1d8;stroke-width:1}
.grid{stroke:#e4e8eb;stroke-width:1}
.burn{stroke:#1d1d1b;stroke-width:1.6;stroke-linecap:round}
.datum{stroke:#1f5fa8;stroke-width:2.2;stroke-linecap:round}
.arrow{stroke:#c2371b;stroke-width:1.3;fill:#c2371b}
.lost{stroke:#c2371b;stroke-width:1.5;fill:none;stroke-dasharray:3 2}
.bar{stroke:#24313d;stroke-width:2}
.axis{stroke:#9aa6b0;stroke-width:1}
.limit{stroke:#c2371b;stroke-width:1.2;stroke-dasharray:7 4}
.lx{stroke:#1f5fa8}
.ly{stroke:#c77700}
.lz{stroke:#2c8a4b}
.pathlimit{stroke:#1d1d1b;stroke-width:1.2;stroke-dasharray:2 3}
.broken{stroke:#c2371b;stroke-width:1;stroke-opacity:0.55}
.brokendot{fill:#c2371b}
.cp,.cx,.cy,.cz,.cc{fill:none;stroke-width:1.1;stroke-linejoin:round}
.cp{stroke:#1d1d1b;stroke-opacity:0.6}
.cx{stroke:#1f5fa8}
.cy{stroke:#c77700}
.cz{stroke:#2c8a4b}
.cc{stroke:#7a3fa0}
)";

std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&': out += "&amp;"; break;
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            case '"': out += "&quot;"; break;
            default:
                // XML allows no other control characters, not even escaped.
                out += static_cast<unsigned char>(c) < 0x20U ? ' ' : c;
        }
    }
    return out;
}

}  // namespace

Svg::Svg(double width, double height) : width_(width), height_(height) {}

void Svg::line(double x1, double y1, double x2, double y2, std::string_view css_class) {
    fmt::format_to(std::back_inserter(body_),
                   "<line class=\"{}\" x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\"/>\n", css_class, x1, y1,
                   x2, y2);
}

void Svg::circle(double x, double y, double radius, std::string_view css_class) {
    fmt::format_to(std::back_inserter(body_), "<circle class=\"{}\" cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\"/>\n",
                   css_class, x, y, radius);
}

void Svg::rect(double x, double y, double width, double height, std::string_view css_class) {
    fmt::format_to(std::back_inserter(body_),
                   "<rect class=\"{}\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"/>\n", css_class, x,
                   y, width, height);
}

void Svg::path(std::string_view d, std::string_view css_class) {
    fmt::format_to(std::back_inserter(body_), "<path class=\"{}\" d=\"{}\"/>\n", css_class, d);
}

void Svg::text(double x, double y, std::string_view content, std::string_view css_class, std::string_view anchor) {
    fmt::format_to(std::back_inserter(body_),
                   "<text class=\"{}\" x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"{}\">{}</text>\n", css_class, x, y,
                   anchor, escaped(content));
}

void Svg::arrow(double x1, double y1, double x2, double y2, std::string_view css_class) {
    constexpr double kHead = 7.0;
    constexpr double kHalfWidth = 2.6;
    const double size = std::hypot(x2 - x1, y2 - y1);
    if (size < kHead) {
        circle(x1, y1, 1.8, css_class);
        return;
    }
    const double ux = (x2 - x1) / size;
    const double uy = (y2 - y1) / size;
    const double bx = x2 - kHead * ux;
    const double by = y2 - kHead * uy;
    line(x1, y1, bx, by, css_class);
    fmt::format_to(std::back_inserter(body_),
                   "<path class=\"{}\" d=\"M{:.2f} {:.2f}L{:.2f} {:.2f}L{:.2f} {:.2f}Z\"/>\n", css_class, x2, y2,
                   bx - kHalfWidth * uy, by + kHalfWidth * ux, bx + kHalfWidth * uy, by - kHalfWidth * ux);
}

void Svg::open_group(std::string_view title) {
    fmt::format_to(std::back_inserter(body_), "<g><title>{}</title>\n", escaped(title));
}

void Svg::close_group() { body_ += "</g>\n"; }

std::string Svg::finish() const {
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" "
        "height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\">\n<style>{2}</style>\n{3}</svg>\n",
        width_, height_, kStyle, body_);
}

}  // namespace sc::host
