// SPDX-License-Identifier: Apache-2.0
// The master against slaves that share no code with it: pymodbus and libmodbus, on a pseudo-terminal. The bus' time is
// virtual: each request waits for its answer in wall time, which then arrives on time.
#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <thread>

#include <gtest/gtest.h>
#include <modbus/modbus.h>
#include <sys/wait.h>

#include "firmware/sensors/modbus_rtu.hpp"
#include "firmware/sensors/sensor_hub.hpp"
#include "shared/machine/machine.hpp"
#include "tests/sim/boards/rs485/pty_pair.hpp"

namespace {

using namespace sc;
using sensors::Quality;

constexpr std::int64_t kPeriodNs = 1'000'000;

/// All on bus 0: slave 1 a triangulation sensor, 2 to 4 phase sensors; values that never change are no fault here.
SensorsConfig one_bus() {
    SensorsConfig config = reference_machine().sensors;
    for (std::size_t i = 0; i < kSensorCount; ++i) {
        config.sensor[i].bus = 0;
        config.sensor[i].address = static_cast<std::uint8_t>(i + 1);
        config.sensor[i].stuck_ns = 0;
        config.sensor[i].identity = i == kYSensor ? 10'602 : 0;
        config.sensor[i].far = 100'000'000;
    }
    return config;
}

class ForeignBus {
public:
    explicit ForeignBus(const SensorsConfig& config = one_bus()) : hub_(config, kPeriodNs) {}
    [[nodiscard]] const PtyPair& pty() const { return pty_; }

    /// Until so many requests have been sent.
    void run(int requests) {
        for (int sent = 0; sent < requests;) {
            ServoInputs in;
            in.tick = tick_;
            in.sensor_rx[0] = coming_;
            ServoOutputs& out = *out_;
            hub_.step(in, out);
            coming_.clear();
            deliver();
            if (out.sensor_tx[0].size > 0) {
                ++sent;
                ask(out.sensor_tx[0]);
            }
            ++tick_;
        }
    }
    [[nodiscard]] sensors::Sample sample(std::size_t i) const { return hub_.sample(i); }
    std::uint32_t answers = 0;

private:
    void ask(const SensorTransmission& sent) {
        pty_.send({sent.bytes.begin(), sent.bytes.begin() + sent.size});
        std::vector<std::uint8_t> answer;
        while (pty_.receive(answer, std::chrono::milliseconds(5000))) {
            const std::size_t whole = sensors::modbus::reply_size(answer);
            if (whole != 0 && answer.size() >= whole) {
                break;
            }
        }
        answers += answer.empty() ? 0U : 1U;
        const auto timing = sensors::bus_timing(one_bus().bus[0]);
        std::int64_t t = (tick_ + 1) * kPeriodNs + sent.delay_ns + sent.size * timing.character + timing.gap;
        for (const std::uint8_t byte : answer) {
            t += timing.character;
            queue_.push_back({t, byte});
        }
    }
    void deliver() {
        const std::int64_t now = (tick_ + 1) * kPeriodNs;
        while (!queue_.empty() && queue_.front().first <= now) {
            const auto age = static_cast<std::uint16_t>((now - queue_.front().first) / 1000);
            coming_.push_back({queue_.front().second, 0, age});
            queue_.erase(queue_.begin());
        }
    }

    PtyPair pty_;
    sensors::SensorHub hub_;
    std::unique_ptr<ServoOutputs> out_ = std::make_unique<ServoOutputs>();
    std::vector<SensorByte> coming_;
    std::vector<std::pair<std::int64_t, std::uint8_t>> queue_;
    std::int64_t tick_ = 0;
};

/// python3 of the system with a script; ended when it goes.
class Python {
public:
    Python(const std::string& script, const std::string& argument) {
        std::array<int, 2> ends{};
        if (::pipe(ends.data()) != 0) {
            throw std::runtime_error("no pipe");
        }
        pid_ = ::fork();
        if (pid_ == 0) {
            ::dup2(ends[1], 1);
            ::execl("/usr/bin/python3", "python3", script.c_str(), argument.c_str(), nullptr);
            std::_Exit(127);
        }
        ::close(ends[1]);
        std::array<char, 8> word{};
        started_ = ::read(ends[0], word.data(), 5) == 5;
        ::close(ends[0]);
    }
    Python(const Python&) = delete;
    Python& operator=(const Python&) = delete;
    ~Python() {
        ::kill(pid_, SIGTERM);
        ::waitpid(pid_, nullptr, 0);
    }
    [[nodiscard]] bool started() const { return started_; }

private:
    pid_t pid_ = -1;
    bool started_ = false;
};

TEST(ForeignSlave, PymodbusSatisfiesTheMaster) {
    ForeignBus bus;
    const Python slave(SC_SOURCE_DIR "/tests/sim/boards/rs485/foreign_slave.py", bus.pty().name());
    ASSERT_TRUE(slave.started()) << "python3-pymodbus is of packages/test.txt";
    bus.run(60);
    // 100 mm + 50 mm · 8192 / 16384.
    EXPECT_EQ(bus.sample(0).value, 12'500'000);
    EXPECT_TRUE(sensors::usable(bus.sample(0).quality)) << static_cast<int>(bus.sample(0).code);
    EXPECT_EQ(bus.sample(0).bad, 0U);
    EXPECT_EQ(bus.sample(1).value, 18'530'000);
    EXPECT_TRUE(sensors::usable(bus.sample(1).quality));
    // Top bit: its own fault 23.
    EXPECT_EQ(bus.sample(2).code, SensorCode::own_fault);
    EXPECT_EQ(bus.sample(2).detail, 23);
    EXPECT_EQ(bus.sample(3).code, SensorCode::exception);
    EXPECT_EQ(bus.sample(3).quality, Quality::faulty);
}

/// libmodbus as slave `unit` on a device, in a thread.
class LibmodbusSlave {
public:
    LibmodbusSlave(const std::string& device, int unit, const std::function<void(modbus_mapping_t&)>& fill)
        : context_(modbus_new_rtu(device.c_str(), 115'200, 'N', 8, 1)), map_(modbus_mapping_new(1, 1, 64, 64)) {
        fill(*map_);
        modbus_set_slave(context_, unit);
        modbus_set_indication_timeout(context_, 0, 200'000);
        if (modbus_connect(context_) != 0) {
            throw std::runtime_error("libmodbus cannot open the pseudo-terminal");
        }
        thread_ = std::thread([this] {
            std::array<std::uint8_t, MODBUS_RTU_MAX_ADU_LENGTH> request{};
            while (!over_) {
                const int size = modbus_receive(context_, request.data());
                if (size > 0) {
                    modbus_reply(context_, request.data(), size, map_);
                }
            }
        });
    }
    LibmodbusSlave(const LibmodbusSlave&) = delete;
    LibmodbusSlave& operator=(const LibmodbusSlave&) = delete;
    ~LibmodbusSlave() {
        over_ = true;
        thread_.join();
        modbus_mapping_free(map_);
        modbus_close(context_);
        modbus_free(context_);
    }
    [[nodiscard]] std::uint16_t holding(std::size_t i) const { return map_->tab_registers[i]; }

private:
    modbus_t* context_;
    modbus_mapping_t* map_;
    std::atomic<bool> over_ = false;
    std::thread thread_;
};

TEST(ForeignSlave, LibmodbusSatisfiesTheMaster) {
    // Alone on its bus: after a request to another slave libmodbus 3.1.6 takes the next request for that one's answer.
    SensorsConfig config = one_bus();
    for (std::size_t i = kFirstTriple; i < kSensorCount; ++i) {
        config.sensor[i].kind = SensorKind::none;
    }
    ForeignBus bus(config);
    const LibmodbusSlave slave(bus.pty().name(), 1, [](modbus_mapping_t& map) {
        const std::array<std::uint16_t, 7> inputs{0, 602, 17, 10'602, 100, 50, 4096};
        std::copy(inputs.begin(), inputs.end(), map.tab_input_registers);
    });
    bus.run(20);
    EXPECT_EQ(bus.sample(0).value, 11'250'000);
    EXPECT_TRUE(sensors::usable(bus.sample(0).quality)) << static_cast<int>(bus.sample(0).code);
    EXPECT_EQ(bus.sample(0).bad, 0U);
    EXPECT_EQ(slave.holding(10), 1) << "its laser has been switched on";
}

}  // namespace
