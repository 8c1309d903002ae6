// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/vision/camera.hpp"
#include "shared/geometry/vec.hpp"

/// What pictures show of a board with points at known places, and how a fit to them stands.

namespace sc::host {

/// A point of the board as one picture shows it.
struct BoardPoint {
    int line = 0;    ///< of a file; 0: of a picture
    int column = 0;  ///< its name on the board
    int row = 0;
    Vec3 place;           ///< metres, on the board
    Pixel seen{};         ///< px
    double sigma = 0.0;   ///< px; 0: as the others
    double radius = 0.0;  ///< metres: a circle, whose ellipse's middle was seen; 0: a point
};

/// One picture, or what a file says of one.
struct BoardView {
    std::string name;  ///< pairs left and right
    int width = 0;     ///< px; 0: not known
    int height = 0;
    std::vector<BoardPoint> points;
};

/// A point that does not fit.
struct WrongPoint {
    std::string view;
    std::size_t camera = 0;  ///< 0: left or the only one
    int column = 0;
    int row = 0;
    int line = 0;
    double off = 0.0;  ///< px
    /// The other point, if the two have changed places.
    std::optional<std::array<int, 2>> swapped;
    [[nodiscard]] std::string text() const;
};

struct ViewFit {
    std::string name;
    bool used = true;
    std::string why;                      ///< it was left out
    std::array<std::size_t, 2> points{};  ///< that count, in each camera
    std::array<double, 2> rms{};          ///< px, of a coordinate
    Mat3 rotation;                        ///< camera_from_board (of a pair, the left one's)
    Vec3 translation;                     ///< metres
    std::array<double, 6> sigma{};        ///< turn on the left (rad), place (m)
    double tilt = 0.0;                    ///< rad, between the board's normal and the view
};

/// A residual of a point that counts, for pictures and tables.
struct PointFit {
    std::size_t view = 0;
    std::size_t camera = 0;
    int column = 0;
    int row = 0;
    bool used = true;
    Pixel seen{};
    Pixel off{};  ///< seen less predicted, px
};

}  // namespace sc::host
