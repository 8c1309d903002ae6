// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/sensors/distance_models.hpp"

#include <cmath>

#include "shared/units/quantity.hpp"

namespace sc::sim {
namespace {

constexpr double kFullScale = 16384.0;
constexpr double kTenthOfMillimetre = 1e-4;

/// SplitMix64 (Steele, Lea, Flood 2014).
std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
}

}  // namespace

SensorNoise::SensorNoise(std::uint64_t seed, std::uint64_t stream) : state_(mix(seed + 1) ^ mix(stream + 0x51ED27U)) {}

double SensorNoise::uniform() {
    state_ += 0x9E3779B97F4A7C15U;
    return static_cast<double>(mix(state_) >> 11U) * 0x1.0p-53;
}

double SensorNoise::gauss() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * kPi * uniform());
}

TriangulationModel::TriangulationModel(const YSensorTruth& truth, std::uint64_t seed, std::uint64_t stream)
    : truth_(truth), noise_(seed, stream) {}

std::optional<std::uint16_t> TriangulationModel::measure(const std::optional<Target>& target) {
    const double lot = noise_.uniform();
    const double noise = noise_.gauss();
    if (lot < truth_.dropouts) {
        return std::nullopt;
    }
    if (!target || target->inclination > truth_.steepest) {
        return std::uint16_t{0};
    }
    const double d = target->distance;
    const double seen = d + truth_.gain * (d - truth_.standoff) +
                        truth_.bend * std::sin(2.0 * kPi * d / truth_.bend_period) +
                        truth_.tilt * std::tan(target->inclination) + truth_.noise * noise;
    const double value = std::round((seen - truth_.base) / truth_.range * kFullScale);
    return value >= 1.0 && value <= kFullScale ? static_cast<std::uint16_t>(value) : std::uint16_t{0};
}

PhaseModel::PhaseModel(const TripleTruth& truth, std::uint64_t seed, std::uint64_t stream)
    : truth_(truth), noise_(seed, stream) {}

std::uint32_t PhaseModel::measure(const std::optional<Target>& target, const TripleTruth::Beam& beam, int slip) {
    const double lot = noise_.uniform();
    const double fine_noise = noise_.gauss();
    const double coarse_noise = noise_.gauss();
    if (!target || target->inclination > truth_.steepest || lot < truth_.dropouts) {
        return kNoSignal;
    }
    const double steep = std::tan(target->inclination);
    const double d = target->distance + beam.zero + beam.gain * target->distance + truth_.tilt * steep +
                     truth_.noise * (1.0 + truth_.tilt_noise * steep * steep) * fine_noise;
    const double phase = 2.0 * kPi * d / truth_.cycle;
    const double fine = d + truth_.cyclic * std::sin(phase);
    const double fraction = fine / truth_.cycle - std::floor(fine / truth_.cycle);
    const double coarse = (d + truth_.coarse_noise * coarse_noise) / truth_.cycle;
    const double cycles = std::round(coarse - fraction) + slip;
    const double value = std::round((cycles + fraction) * truth_.cycle / kTenthOfMillimetre);
    return value >= 0.0 && value < 1e9 ? static_cast<std::uint32_t>(value) : kNoSignal;
}

}  // namespace sc::sim
