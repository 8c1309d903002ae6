// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace sc::host {

/// Writes SVG elements; all text is escaped. Coordinates are user units of the picture, y down.
class Svg {
public:
    Svg(double width, double height);

    void line(double x1, double y1, double x2, double y2, std::string_view css_class);
    void circle(double x, double y, double radius, std::string_view css_class);
    void rect(double x, double y, double width, double height, std::string_view css_class);
    /// `d`: path data, taken as it is.
    void path(std::string_view d, std::string_view css_class);
    /// `anchor`: "start", "middle" or "end".
    void text(double x, double y, std::string_view content, std::string_view css_class,
              std::string_view anchor = "start");
    /// A shaft with a head of fixed size at (x2, y2); a dot if it is shorter than the head.
    void arrow(double x1, double y1, double x2, double y2, std::string_view css_class);
    void open_group(std::string_view title);
    void close_group();

    /// The whole picture, with its style sheet inside.
    [[nodiscard]] std::string finish() const;

private:
    double width_;
    double height_;
    std::string body_;
};

}  // namespace sc::host
