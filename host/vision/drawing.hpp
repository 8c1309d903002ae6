// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "host/vision/grey_image.hpp"

/// Simple pictures of figures and views, kept as shapes, so that an SVG and pixels show the same.

namespace sc::host {

enum class Stroke : std::uint8_t { reference, object, beam, guide, thin };
enum class Font : std::uint8_t { figure, heading, small, number, warning };
enum class Anchor : std::uint8_t { start, middle, end };

/// Pixels, x to the right, y down. Shapes are drawn in their order, on white.
struct Drawing {
    struct Line {
        std::array<double, 2> from{};
        std::array<double, 2> to{};
        Stroke stroke = Stroke::thin;
    };
    /// Less than half a circle about `centre`; angles in radians, counter-clockwise as seen, 0 to the right.
    struct Arc {
        std::array<double, 2> centre{};
        double radius = 0.0;
        std::array<double, 2> angle{};
    };
    struct Disc {
        std::array<double, 2> centre{};
        double radius = 0.0;
    };
    struct Panel {
        std::array<double, 2> corner{};  ///< left, top
        std::array<double, 2> size{};
    };
    struct Text {
        std::array<double, 2> at{};  ///< on the base line
        Font font = Font::small;
        Anchor anchor = Anchor::start;
        std::string text;  ///< UTF-8
    };
    int width = 0;
    int height = 0;
    std::vector<std::variant<Line, Arc, Disc, Panel, Text>> shapes;
};

[[nodiscard]] std::string svg_of(const Drawing& drawing);
/// Anti-aliased, in a stroke font of ASCII: "°" becomes " deg", what else it has not got "?". Some 5 ms.
[[nodiscard]] ColourImage pixels_of(const Drawing& drawing);

}  // namespace sc::host
