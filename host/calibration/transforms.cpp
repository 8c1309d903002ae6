// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/transforms.hpp"

#include <array>
#include <cmath>

#include "shared/units/quantity.hpp"

namespace sc::host {

namespace {

struct SineCosine {
    double sine;
    double cosine;
};

SineCosine sine_cosine(double degrees) noexcept {
    const double within_turn = std::remainder(degrees, 360.0);
    const double quarters = std::nearbyint(within_turn / 90.0);
    const double rest = (within_turn - 90.0 * quarters) * (kPi / 180.0);
    const double s = std::sin(rest);
    const double c = std::cos(rest);
    const std::array<SineCosine, 4> by_quarter{{{s, c}, {c, -s}, {-s, -c}, {-c, s}}};
    return by_quarter[static_cast<std::size_t>(static_cast<int>(quarters) + 4) % 4];
}

}  // namespace

Rigid<frame::H, frame::T> h_from_t(const AxisLine& axis, double c_deg) noexcept {
    const auto [sine, cosine] = sine_cosine(c_deg);
    return turned(axis, sine, cosine);
}

Point<frame::H> to_face(const CalibrationSet& set, const Point<frame::C>& place, double face_deg) {
    const Point<frame::H> at_zero = h_from_c(set) * place;
    return h_from_t(turntable_axis(set), c_of_face(face_deg)) * Point<frame::T>{at_zero.v};
}

Point<frame::H> to_face(const CalibrationSet& set, const Rigid<frame::C, frame::W>& c_from_w,
                        const Point<frame::W>& place, double face_deg) {
    return to_face(set, c_from_w * place, face_deg);
}

Point<frame::C> from_face(const CalibrationSet& set, const Point<frame::H>& place, double face_deg) {
    const Point<frame::T> on_table = h_from_t(turntable_axis(set), c_of_face(face_deg)).inverse() * place;
    return h_from_c(set).inverse() * Point<frame::H>{on_table.v};
}

}  // namespace sc::host
