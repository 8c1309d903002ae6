// SPDX-License-Identifier: Apache-2.0
// The hub through libmodbus on pseudo-terminals, with the simulated sensors as slaves. In wall time: only order and
// values are judged, never speed.
#include "boards/rs485/modbus_port.hpp"

#include <atomic>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include "boards/sim/sensors/sensor_devices.hpp"
#include "firmware/sensors/sensor_hub.hpp"
#include "shared/machine/machine.hpp"
#include "tests/sim/boards/rs485/pty_pair.hpp"

namespace {

using namespace sc;
using sensors::Quality;

constexpr std::int64_t kPeriodNs = 1'000'000;

SensorsConfig patient() {
    SensorsConfig config = reference_machine().sensors;
    for (SensorConfig& sensor : config.sensor) {
        // A busy machine may hold the threads up.
        sensor.patience_ns = 300'000'000;
        sensor.too_old_ns = 3'000'000'000;
        sensor.stuck_ns = 0;
    }
    return config;
}

/// Simulated devices of one bus behind a pseudo-terminal.
class DeviceThread {
public:
    DeviceThread() : thread_([this] { serve(); }) {}
    DeviceThread(const DeviceThread&) = delete;
    DeviceThread& operator=(const DeviceThread&) = delete;
    ~DeviceThread() {
        over_ = true;
        thread_.join();
    }
    PtyPair pty;
    std::mutex mutex;  ///< of `devices`
    std::vector<sim::ModbusDevice*> devices;

private:
    void serve() {
        std::vector<std::uint8_t> request;
        while (!over_) {
            if (pty.receive(request, std::chrono::milliseconds(20))) {
                continue_ = true;
                if (request.size() < 8 || (request[1] == 16 && request.size() < 11)) {
                    continue;
                }
            } else {
                request.clear();
                continue;
            }
            const std::lock_guard lock(mutex);
            for (sim::ModbusDevice* device : devices) {
                now_ns_ += kPeriodNs;
                const auto answer = device->serve(request, now_ns_ + 1'000'000'000);
                if (!answer.empty()) {
                    pty.send(answer);
                }
            }
            request.clear();
        }
    }
    std::atomic<bool> over_ = false;
    bool continue_ = false;
    std::int64_t now_ns_ = 0;
    std::thread thread_;
};

class PortTest : public testing::Test {
protected:
    PortTest() {
        const SensorsConfig config = patient();
        truth_.noise = truth_.bend = truth_.tilt = truth_.gain = truth_.dropouts = 0.0;
        truth_.serial = 10'602;
        head_.noise = head_.dropouts = head_.cyclic = head_.coarse_noise = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            head_.beam.at(i).stored_offset = static_cast<double>(3 + 4 * i);
            phases_.push_back(std::make_unique<sim::PhaseDevice>(config.bus[1], config.sensor[1 + i], head_, i, 1, i));
            triple_.devices.push_back(phases_.back().get());
        }
        y_.devices.push_back(&triangulation_);
        ports_[0] = std::make_unique<rs485::ModbusPort>(y_.pty.name(), config.bus[0]);
        ports_[1] = std::make_unique<rs485::ModbusPort>(triple_.pty.name(), config.bus[1]);
    }

    void run(int ticks) {
        for (int i = 0; i < ticks; ++i, ++tick_) {
            measure();
            ServoInputs in;
            in.tick = tick_;
            for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
                in.sensor_rx.at(bus) = ports_.at(bus)->take(tick_ * kPeriodNs);
            }
            hub_.step(in, *out_);
            for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
                ports_.at(bus)->give(tick_ * kPeriodNs, kPeriodNs, out_->sensor_tx.at(bus));
            }
            std::this_thread::sleep_for(std::chrono::microseconds(1000));
        }
    }
    void measure() {
        if (tick_ % 20 != 0) {
            return;
        }
        {
            const std::lock_guard lock(y_.mutex);
            triangulation_.measure(0, sim::Target{0.125, 0.0});
        }
        const std::lock_guard lock(triple_.mutex);
        for (std::size_t i = 0; i < 3; ++i) {
            phases_.at(i)->measure(0, sim::Target{0.180 + 0.01 * static_cast<double>(i), 0.0});
        }
    }

    sim::YSensorTruth truth_;
    sim::TripleTruth head_;
    DeviceThread y_;
    DeviceThread triple_;
    sim::TriangulationDevice triangulation_{patient().bus[0], patient().sensor[0], truth_with_serial(), 1, 9};
    std::vector<std::unique_ptr<sim::PhaseDevice>> phases_;
    sensors::SensorHub hub_{patient(), kPeriodNs};
    std::unique_ptr<ServoOutputs> out_ = std::make_unique<ServoOutputs>();
    std::array<std::unique_ptr<rs485::ModbusPort>, kSensorBuses> ports_;
    std::int64_t tick_ = 0;

private:
    static sim::YSensorTruth truth_with_serial() {
        sim::YSensorTruth truth;
        truth.serial = 10'602;
        return truth;
    }
};

TEST_F(PortTest, AllFourSensorsAreReadThroughLibmodbus) {
    for (int i = 0; i < 20; ++i) {
        run(200);
        if (hub_.sample(0).count > 5 && hub_.sample(1).count > 2 && hub_.sample(2).count > 2 &&
            hub_.sample(3).count > 2) {
            break;
        }
    }
    EXPECT_NEAR(hub_.sample(0).value, 12'500'000, 200);
    EXPECT_EQ(hub_.sample(1).value, 18'000'000);
    EXPECT_EQ(hub_.sample(2).value, 19'000'000);
    EXPECT_EQ(hub_.sample(3).value, 20'000'000);
}

TEST_F(PortTest, WhatLibmodbusWouldDropIsToldApartByTheMaster) {
    const std::array<std::pair<sim::SensorTrouble, SensorCode>, 3> cases{
        {{sim::SensorTrouble::crc, SensorCode::bad_crc},
         {sim::SensorTrouble::wrong_slave, SensorCode::wrong_slave},
         {sim::SensorTrouble::exception, SensorCode::exception}}};
    for (const auto& [trouble, code] : cases) {
        {
            const std::lock_guard lock(y_.mutex);
            triangulation_.trouble(trouble);
        }
        for (int i = 0; i < 20 && hub_.sample(0).code != code; ++i) {
            run(200);
        }
        EXPECT_EQ(static_cast<int>(hub_.sample(0).code), static_cast<int>(code));
    }
}

}  // namespace
