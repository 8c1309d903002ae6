// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "boards/sim/sensors/sensor_plant.hpp"
#include "firmware/sensors/sensor_hub.hpp"
#include "shared/machine/machine.hpp"

namespace sc {

/// The default world with a plate before the Y sensor and one beside the triple head.
inline sim::WorldSpec plate_world() {
    sim::WorldSpec spec = sim::read_world_spec(SC_SOURCE_DIR "/boards/sim/world/default/world.toml");
    spec.meshes.clear();
    return spec;
}
inline sim::Mesh plates() {
    sim::Mesh mesh;
    const auto square = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
        const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), {a, b, c, d});
        mesh.triangles.push_back({n, n + 1, n + 2});
        mesh.triangles.push_back({n, n + 2, n + 3});
    };
    // Faces the head at y = −330 mm; faces the triple head at x = −35 mm, turned by 2°.
    square({-0.45, -0.330, -0.46}, {-0.05, -0.330, -0.46}, {-0.05, -0.330, -0.2}, {-0.45, -0.330, -0.2});
    square({-0.035, -0.66, -0.46}, {-0.035, -0.34, -0.46}, {-0.030, -0.34, -0.2}, {-0.030, -0.66, -0.2});
    return mesh;
}

/// Sensor hub and simulated sensors, tick by tick, with nothing else.
class SensorRig {
public:
    explicit SensorRig(const sim::WorldSpec& spec = plate_world(),
                       const SensorsConfig& config = reference_machine().sensors)
        : world_(spec, plates()), plant_(config, world_), hub_(config, kPeriodNs) {}

    void tick() {
        newest_ = 1 - newest_;
        ServoInputs in;
        in.tick = tick_;
        plant_.take(tick_ * kPeriodNs, rx_);
        for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
            in.sensor_rx.at(bus) = rx_.at(bus);
        }
        hub_.step(in, *outputs_.at(newest_));
        for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
            requests_.at(bus) += outputs_.at(newest_)->sensor_tx.at(bus).size > 0 ? 1U : 0U;
        }
        plant_.transmit(tick_ * kPeriodNs, outputs_.at(1 - newest_)->sensor_tx);
        for (int step = 1; step <= 10; ++step) {
            plant_.step_to(tick_ * kPeriodNs + step * kPeriodNs / 10, reading, 0.0);
        }
        ++tick_;
    }
    void run(double seconds) {
        for (const std::int64_t end = tick_ + static_cast<std::int64_t>(seconds * 1e3); tick_ < end;) {
            tick();
        }
    }
    /// True distance that a sensor's beam meets, 10 nm.
    [[nodiscard]] double truth(std::size_t sensor) const { return plant_.target(sensor, reading, 0.0)->distance * 1e8; }
    [[nodiscard]] sensors::Sample sample(std::size_t sensor) const { return hub_.sample(sensor); }
    [[nodiscard]] sim::SensorPlant& plant() { return plant_; }
    [[nodiscard]] sensors::SensorHub& hub() { return hub_; }
    [[nodiscard]] std::int64_t now_ns() const { return (tick_ - 1) * kPeriodNs; }
    [[nodiscard]] std::uint32_t requests(std::size_t bus) const { return requests_.at(bus); }

    static constexpr std::int64_t kPeriodNs = 1'000'000;
    Vec3 reading{-0.2, -0.330, -0.3};

private:
    sim::World world_;
    sim::SensorPlant plant_;
    sensors::SensorHub hub_;
    std::array<std::vector<SensorByte>, kSensorBuses> rx_;
    std::array<std::unique_ptr<ServoOutputs>, 2> outputs_{std::make_unique<ServoOutputs>(),
                                                          std::make_unique<ServoOutputs>()};
    std::array<std::uint32_t, kSensorBuses> requests_{};
    std::size_t newest_ = 0;
    std::int64_t tick_ = 0;
};

}  // namespace sc
