// SPDX-License-Identifier: Apache-2.0
#include "host/vision/drawing.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace sc::host {

namespace {

struct Colour {
    int red;
    int green;
    int blue;
};

constexpr Colour kDark{29, 39, 51};
constexpr Colour kGrey{91, 104, 118};
constexpr Colour kRed{211, 51, 51};
constexpr Colour kWhite{255, 255, 255};
constexpr Colour kPanelFill{246, 248, 250};
constexpr Colour kPanelEdge{215, 221, 227};

struct Pen {
    Colour colour;
    double width;
    bool dashed;
};

Pen pen_of(Stroke stroke) {
    switch (stroke) {
        case Stroke::reference: return {{58, 110, 165}, 4.0, false};
        case Stroke::object: return {{196, 86, 43}, 4.0, false};
        case Stroke::beam: return {kRed, 1.2, true};
        case Stroke::guide: return {kPanelEdge, 1.0, false};
        case Stroke::thin: return {kDark, 1.5, false};
    }
    return {kDark, 1.0, false};
}

struct Face {
    Colour colour;
    double size;
    bool bold;
};

Face face_of(Font font) {
    switch (font) {
        case Font::figure: return {kDark, 26.0, true};
        case Font::heading: return {kDark, 16.0, true};
        case Font::small: return {kGrey, 12.0, false};
        case Font::number: return {kWhite, 12.0, true};
        case Font::warning: return {{179, 38, 30}, 22.0, true};
    }
    return {kDark, 12.0, false};
}

std::string hex(const Colour& c) { return fmt::format("#{:02x}{:02x}{:02x}", c.red, c.green, c.blue); }

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

const char* name_of(Anchor anchor) {
    switch (anchor) {
        case Anchor::start: return "start";
        case Anchor::middle: return "middle";
        case Anchor::end: return "end";
    }
    return "start";
}

std::array<double, 2> on(const Drawing::Arc& arc, double angle) {
    return {arc.centre[0] + arc.radius * std::cos(angle), arc.centre[1] - arc.radius * std::sin(angle)};
}

/// One shape as SVG.
struct SvgWriter {
    std::string operator()(const Drawing::Line& line) const {
        const Pen pen = pen_of(line.stroke);
        return fmt::format(
            "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"{}\"{}/>\n",
            line.from[0], line.from[1], line.to[0], line.to[1], hex(pen.colour), pen.width,
            pen.dashed ? " stroke-dasharray=\"5 4\"" : "");
    }
    std::string operator()(const Drawing::Arc& arc) const {
        const auto from = on(arc, arc.angle[0]);
        const auto to = on(arc, arc.angle[1]);
        return fmt::format(
            "<path d=\"M{:.1f} {:.1f} A{r} {r} 0 0 {sweep} {:.1f} {:.1f}\" fill=\"none\" stroke=\"{colour}\" "
            "stroke-width=\"1.5\"/>\n",
            from[0], from[1], to[0], to[1], fmt::arg("r", arc.radius),
            fmt::arg("sweep", arc.angle[1] > arc.angle[0] ? 0 : 1), fmt::arg("colour", hex(kDark)));
    }
    std::string operator()(const Drawing::Disc& disc) const {
        return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"{}\"/>\n", disc.centre[0],
                           disc.centre[1], disc.radius, hex(kRed));
    }
    std::string operator()(const Drawing::Panel& panel) const {
        return fmt::format(
            "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"6\" fill=\"{}\" stroke=\"{}\"/>\n",
            panel.corner[0], panel.corner[1], panel.size[0], panel.size[1], hex(kPanelFill), hex(kPanelEdge));
    }
    std::string operator()(const Drawing::Text& text) const {
        const Face face = face_of(text.font);
        return fmt::format(
            "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" fill=\"{}\" font-size=\"{}\"{}>{}</text>\n", text.at[0],
            text.at[1], name_of(text.anchor), hex(face.colour), face.size, face.bold ? " font-weight=\"600\"" : "",
            escaped(text.text));
    }
};

/// Bytes beyond ASCII: the degree sign in words, others as "?", one for each character.
std::string ascii_of(const std::string& text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto byte = static_cast<unsigned char>(text[i]);
        if (byte < 0x80U) {
            out += text[i];
        } else if (text.compare(i, 2, "\u00b0") == 0) {
            out += " deg";
            ++i;
        } else if ((byte & 0xC0U) == 0xC0U) {
            out += '?';
        }
    }
    return out;
}

constexpr int kFraction = 4;  ///< bits of a pixel that OpenCV's lines are given in

cv::Point fine(const std::array<double, 2>& p) {
    constexpr double kOne = 1 << kFraction;
    return {static_cast<int>(std::lround(p[0] * kOne)), static_cast<int>(std::lround(p[1] * kOne))};
}

cv::Scalar scalar(const Colour& c) {
    return {static_cast<double>(c.red), static_cast<double>(c.green), static_cast<double>(c.blue)};
}

/// Shapes onto a picture of red, green, blue.
class Painter {
public:
    explicit Painter(cv::Mat& picture) : picture_(picture) {}

    void operator()(const Drawing::Line& line) const {
        const Pen pen = pen_of(line.stroke);
        const int width = static_cast<int>(std::lround(pen.width));
        if (!pen.dashed) {
            cv::line(picture_, fine(line.from), fine(line.to), scalar(pen.colour), width, cv::LINE_AA, kFraction);
            return;
        }
        constexpr double kDash = 5.0;
        constexpr double kGap = 4.0;
        const double dx = line.to[0] - line.from[0];
        const double dy = line.to[1] - line.from[1];
        const double length = std::hypot(dx, dy);
        for (int dash = 0; dash * (kDash + kGap) < length; ++dash) {
            const double s = dash * (kDash + kGap);
            const double e = std::min(s + kDash, length);
            cv::line(picture_, fine({line.from[0] + dx * s / length, line.from[1] + dy * s / length}),
                     fine({line.from[0] + dx * e / length, line.from[1] + dy * e / length}), scalar(pen.colour), width,
                     cv::LINE_AA, kFraction);
        }
    }
    void operator()(const Drawing::Arc& arc) const {
        constexpr int kPieces = 48;
        for (int k = 0; k < kPieces; ++k) {
            const auto at = [&](int i) { return arc.angle[0] + (arc.angle[1] - arc.angle[0]) * i / kPieces; };
            cv::line(picture_, fine(on(arc, at(k))), fine(on(arc, at(k + 1))), scalar(kDark), 1, cv::LINE_AA,
                     kFraction);
        }
    }
    void operator()(const Drawing::Disc& disc) const {
        cv::circle(picture_, fine(disc.centre), fine({disc.radius, 0.0}).x, scalar(kRed), cv::FILLED, cv::LINE_AA,
                   kFraction);
    }
    void operator()(const Drawing::Panel& panel) const {
        const std::array far{panel.corner[0] + panel.size[0], panel.corner[1] + panel.size[1]};
        cv::rectangle(picture_, fine(panel.corner), fine(far), scalar(kPanelFill), cv::FILLED, cv::LINE_8, kFraction);
        cv::rectangle(picture_, fine(panel.corner), fine(far), scalar(kPanelEdge), 1, cv::LINE_8, kFraction);
    }
    void operator()(const Drawing::Text& text) const {
        // Capitals of OpenCV's plain font are 21 units high, and its text is wide: 0.6 of the size asked for, not 0.7.
        constexpr double kScale = 0.6 / 21.0;
        const Face face = face_of(text.font);
        const int font = cv::FONT_HERSHEY_SIMPLEX;
        const int width = face.bold && face.size > 14.0 ? 2 : 1;
        const std::string ascii = ascii_of(text.text);
        int below = 0;
        const cv::Size size = cv::getTextSize(ascii, font, kScale * face.size, width, &below);
        const double share = text.anchor == Anchor::start ? 0.0 : text.anchor == Anchor::middle ? 0.5 : 1.0;
        const cv::Point at(static_cast<int>(std::lround(text.at[0] - share * size.width)),
                           static_cast<int>(std::lround(text.at[1])));
        cv::putText(picture_, ascii, at, font, kScale * face.size, scalar(face.colour), width, cv::LINE_AA);
    }

private:
    cv::Mat& picture_;
};

}  // namespace

std::string svg_of(const Drawing& drawing) {
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" "
        "font-family=\"sans-serif\"><rect width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>\n",
        fmt::arg("w", drawing.width), fmt::arg("h", drawing.height));
    for (const auto& shape : drawing.shapes) {
        out += std::visit(SvgWriter{}, shape);
    }
    return out + "</svg>\n";
}

ColourImage pixels_of(const Drawing& drawing) {
    cv::Mat picture(drawing.height, drawing.width, CV_8UC3, cv::Scalar(255.0, 255.0, 255.0));
    const Painter painter(picture);
    for (const auto& shape : drawing.shapes) {
        std::visit(painter, shape);
    }
    ColourImage out{.width = drawing.width, .height = drawing.height, .pixel = {}};
    out.pixel.assign(picture.datastart, picture.dataend);
    return out;
}

}  // namespace sc::host
