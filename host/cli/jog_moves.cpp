// SPDX-License-Identifier: Apache-2.0
#include "host/cli/jog_moves.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

#include "host/bridge/errors.hpp"
#include "shared/path/item.hpp"

namespace sc::host::cli {
namespace {

constexpr double kLargest = 10e-3;
constexpr double kLargestTurn = 10.0;
constexpr double kFast = 50.0;      ///< mm/s
constexpr double kFastTurn = 20.0;  ///< degrees/s
constexpr double kNear = 2e-6;
constexpr Nanoseconds kBegin = std::chrono::milliseconds(100);
constexpr Nanoseconds kLook = std::chrono::milliseconds(2);
constexpr Nanoseconds kLongest = std::chrono::seconds(5);
constexpr Nanoseconds kSettle = std::chrono::milliseconds(60);
constexpr Nanoseconds kSensorLimit = std::chrono::seconds(3);

}  // namespace

void guide_light(CellClient& client) {
    try {
        client.command(link::Verb::guide, 1);
    } catch (const CellRefused& refused) {
        std::fprintf(stderr, "no guide light: %s\n", refused.what());
    }
}

std::int32_t jog_speed(Axis axis, double distance) {
    const bool turn = axis == Axis::c;
    const double size = std::abs(distance) * (turn ? 1.0 : 1e3);
    return static_cast<std::int32_t>(std::llround(1e3 * std::min(turn ? kFastTurn : kFast, 1.0 + 10.0 * size)));
}

bool JogMoves::step(std::size_t axis, double distance, const std::function<bool()>& stop) {
    const bool turn = axis == 3;
    const double units = turn ? kWireUnitsPerDegree : kWireUnitsPerMetre;
    const auto way = static_cast<std::int32_t>(std::llround(distance * units));
    if (way == 0) {
        return true;
    }
    bool begun = false;
    client_->on_state([&begun](State, State to) { begun = begun || to == State::jogging; });
    client_->command(link::Verb::jog, static_cast<std::int32_t>(axis), way,
                     jog_speed(static_cast<Axis>(axis), distance));
    client_->pump_until([&] { return begun; }, kBegin);
    const bool stopped = stop && !watch(stop);
    client_->wait_for({State::idle}, std::chrono::seconds(5), "the jog");
    client_->on_state({});
    return !stopped;
}

/// False: `stop` has said so while the axis moved.
bool JogMoves::watch(const std::function<bool()>& stop) {
    const HostTime end = client_->now() + kLongest;
    while (client_->state() == State::jogging && client_->now() < end) {
        if (stop()) {
            try {
                client_->command(link::Verb::stop);
            } catch (const CellRefused&) {
                return true;  // the axis has come to rest meanwhile
            }
            return false;
        }
        client_->pump(client_->now() + kLook);
    }
    return true;
}

bool JogMoves::by(std::size_t axis, double distance, const std::function<bool()>& stop) {
    const double largest = axis == 3 ? kLargestTurn : kLargest;
    const auto steps = static_cast<int>(std::ceil(std::abs(distance) / largest - 1e-9));
    for (int i = 0; i < steps; ++i) {
        if (!step(axis, distance / steps, stop)) {
            return false;
        }
    }
    return true;
}

void JogMoves::to(const Vec3& target) {
    for (int attempt = 0; attempt < 3; ++attempt) {
        const Vec3 off = target - place();
        if (std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) < kNear) {
            return;
        }
        if (off.y > 0.0) {
            by(1, off.y);
        }
        by(0, off.x);
        by(2, off.z);
        if (off.y < 0.0) {
            by(1, off.y);
        }
    }
}

void JogMoves::turn_to(double c_deg) { by(3, c_deg - reading()[3]); }

std::array<double, 4> JogMoves::reading() {
    client_->pump_until([] { return false; }, kSettle);
    const auto& actual = client_->status()->actual;
    return {actual[0] / kWireUnitsPerMetre, actual[1] / kWireUnitsPerMetre, actual[2] / kWireUnitsPerMetre,
            actual[3] / kWireUnitsPerDegree};
}

std::optional<JogMoves::Distance> JogMoves::distance(std::size_t sensor, int samples) {
    std::vector<double> values;
    std::uint32_t seen = client_->read_sensors().count.at(sensor);
    const HostTime end = client_->now() + kSensorLimit;
    while (values.size() < static_cast<std::size_t>(samples)) {
        const link::SensorReport report = client_->read_sensors();
        if (report.code.at(sensor) == 0 && report.quality.at(sensor) == 1 && report.count.at(sensor) != seen) {
            seen = report.count.at(sensor);
            values.push_back(report.value.at(sensor) / kWireUnitsPerMetre);
        }
        if (client_->now() > end) {
            return std::nullopt;
        }
        client_->pump_until([] { return false; }, std::chrono::milliseconds(5));
    }
    Distance out;
    for (const double v : values) {
        out.mean += v / samples;
    }
    for (const double v : values) {
        out.sigma += (v - out.mean) * (v - out.mean);
    }
    out.sigma = std::sqrt(out.sigma / std::max(1, samples - 1) / samples);
    return out;
}

}  // namespace sc::host::cli
