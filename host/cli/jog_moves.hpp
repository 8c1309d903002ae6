// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "host/bridge/client.hpp"
#include "shared/geometry/vec.hpp"

/// Moves of a person's kind: axis by axis, in steps that a jog may have, with readings at their end.

namespace sc::host::cli {

/// Asks for the guide laser, to point by. Where the cell does not give it, says why on stderr: one can go on without.
void guide_light(CellClient& client);
/// Of a jog of so many metres (C: degrees), in link::Verb::jog's units: slow when small.
[[nodiscard]] std::int32_t jog_speed(Axis axis, double distance);

class JogMoves {
public:
    /// The cell must be idle, powered and homed (Session::enable_and_home) when moves begin.
    explicit JogMoves(CellClient& client) : client_(&client) {}

    /// Moves one axis (0 to 2: metres; 3: degrees) by so much, in steps of 10 mm or degrees at most. Throws CellRefused
    /// with what the cell says, CellFault, Interrupted. `stop` is asked all along: true ends the move where it is, and
    /// `by` returns false once the axis is at rest.
    bool by(std::size_t axis, double distance, const std::function<bool()>& stop = {});
    /// To a reading (metres): y first when it rises, last when it falls; until the reading is within 2 um, or three
    /// tries.
    void to(const Vec3& reading);
    void turn_to(double c_deg);
    /// What the encoders say now: x, y, z in metres, C in degrees.
    [[nodiscard]] std::array<double, 4> reading();
    [[nodiscard]] Vec3 place() {
        const auto r = reading();
        return {r[0], r[1], r[2]};
    }
    /// Mean and standard deviation of the mean of so many measurements of a distance sensor (0: the Y sensor), metres;
    /// nothing where it is not fitted or gives none within 3 s.
    struct Distance {
        double mean = 0.0;
        double sigma = 0.0;
    };
    [[nodiscard]] std::optional<Distance> distance(std::size_t sensor, int samples);

private:
    bool step(std::size_t axis, double distance, const std::function<bool()>& stop);
    bool watch(const std::function<bool()>& stop);

    CellClient* client_;
};

}  // namespace sc::host::cli
