// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "boards/sim/world/world_spec.hpp"

namespace sc::sim {

/// Random numbers of one sensor, the same for the same seed and stream on every machine with the same libm.
class SensorNoise {
public:
    SensorNoise(std::uint64_t seed, std::uint64_t stream);
    [[nodiscard]] double uniform();  ///< [0, 1)
    [[nodiscard]] double gauss();    ///< mean 0, σ 1

private:
    std::uint64_t state_;
};

/// What a sensor's beam meets.
struct Target {
    double distance = 0.0;     ///< metres, along the beam
    double inclination = 0.0;  ///< rad, between the beam and the surface's normal
};

/// Triangulation: a spot seen at an angle on a line of pixels, linearised, averaged over the period.
class TriangulationModel {
public:
    TriangulationModel(const YSensorTruth& truth, std::uint64_t seed, std::uint64_t stream);
    /// The value register: 1..16384 over the range, 0 without target; nullopt when the measurement failed and the
    /// value of before stays.
    [[nodiscard]] std::optional<std::uint16_t> measure(const std::optional<Target>& target);

private:
    YSensorTruth truth_;
    SensorNoise noise_;
};

/// Phase shift: distance = (whole cycles + phase / 2π) · cycle. The fine phase is exact but ambiguous; a coarse one
/// counts the cycles, and miscounts when its noise is of the order of half a cycle.
class PhaseModel {
public:
    static constexpr std::uint32_t kFaultBit = 0x8000'0000U;
    static constexpr std::uint32_t kNoSignal = kFaultBit | 15U;

    PhaseModel(const TripleTruth& truth, std::uint64_t seed, std::uint64_t stream);
    /// The value: 0.1 mm, or a fault code with its top bit set. `beam`: whose gain and zero; `slip`: whole cycles
    /// that are counted wrongly.
    [[nodiscard]] std::uint32_t measure(const std::optional<Target>& target, const TripleTruth::Beam& beam, int slip);

private:
    TripleTruth truth_;
    SensorNoise noise_;
};

}  // namespace sc::sim
