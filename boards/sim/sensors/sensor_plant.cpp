// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/sensors/sensor_plant.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "boards/sim/world/machine_errors.hpp"

namespace sc::sim {

SensorPlant::SensorPlant(const SensorsConfig& config, const World& world)
    : world_(&world), lines_{Rs485Line(config.bus[0]), Rs485Line(config.bus[1])} {
    const SensorsTruth& truth = world.spec().sensors;
    const auto seed = static_cast<std::uint64_t>(truth.seed);
    for (std::size_t i = 0; i < kSensorCount; ++i) {
        mount_.at(i) = i;
        const SensorConfig& one = config.sensor.at(i);
        if (one.kind == SensorKind::none) {
            continue;
        }
        const SensorBusConfig& bus = config.bus.at(one.bus);
        if (one.kind == SensorKind::triangulation) {
            devices_.at(i) = std::make_unique<TriangulationDevice>(bus, one, truth.y, seed, i);
        } else if (one.kind == SensorKind::phase) {
            const std::size_t beam = i >= kFirstTriple ? i - kFirstTriple : 0;
            devices_.at(i) = std::make_unique<PhaseDevice>(bus, one, truth.triple, beam, seed, i);
        } else {
            devices_.at(i) = std::make_unique<AsciiDevice>(bus, one, truth.y, seed, i);
        }
        lines_.at(one.bus).attach(*devices_.at(i));
    }
}

void SensorPlant::transmit(std::int64_t window_ns, const std::array<SensorTransmission, kSensorBuses>& sent) {
    for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
        const SensorTransmission& one = sent.at(bus);
        if (one.size > 0) {
            lines_.at(bus).transmit(window_ns + one.delay_ns, std::span(one.bytes).first(one.size));
        }
    }
}

Ray SensorPlant::ray(std::size_t place, const Vec3& reading) const {
    const SensorsTruth& truth = world_->spec().sensors;
    if (place == kYSensor) {
        const Vec3 focus = true_focus(world_->spec().axes, reading);
        const Vec3 origin{focus.x + truth.y.offset_x, focus.y + truth.y.standoff, focus.z + truth.y.offset_z};
        return {origin, Vec3{truth.y.lean_x, -1.0, truth.y.lean_z}};
    }
    const TripleTruth::Beam& beam = truth.triple.beam.at(place - kFirstTriple);
    return {beam.place, Vec3{-1.0, beam.lean_y, beam.lean_z}};
}

std::optional<Target> SensorPlant::target(std::size_t sensor, const Vec3& reading, double c_deg) const {
    const Ray beam = ray(mount_.at(sensor), reading);
    const std::optional<Hit> hit = world_->hit(beam, c_deg);
    if (!hit) {
        return std::nullopt;
    }
    const double cosine = std::abs(dot(hit->normal, beam.direction)) / norm(beam.direction);
    return Target{norm(hit->point - beam.origin), std::acos(std::min(cosine, 1.0))};
}

void SensorPlant::step_to(std::int64_t t_ns, const Vec3& reading, double c_deg) {
    for (std::size_t i = 0; i < kSensorCount; ++i) {
        if (devices_.at(i) && devices_.at(i)->next_measurement_ns() <= t_ns) {
            devices_.at(i)->measure(t_ns, target(i, reading, c_deg));
        }
    }
    for (Rs485Line& line : lines_) {
        line.run_to(t_ns);
    }
}

void SensorPlant::take(std::int64_t t_ns, std::array<std::vector<SensorByte>, kSensorBuses>& out) {
    for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
        out.at(bus).clear();
        lines_.at(bus).take(t_ns, out.at(bus));
    }
}

void SensorPlant::trouble(std::size_t sensor, SensorTrouble what) {
    if (devices_.at(sensor)) {
        devices_.at(sensor)->trouble(what);
    }
}

void SensorPlant::swap_with_next(std::size_t sensor) {
    const std::size_t next = sensor + 1 < kSensorCount ? sensor + 1 : kFirstTriple;
    std::swap(mount_.at(sensor), mount_.at(next));
}

}  // namespace sc::sim
