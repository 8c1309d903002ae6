// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/output_hashes.hpp"

#include <array>
#include <span>

#include "shared/codes/state.hpp"
#include "shared/trace/trace.hpp"
#include "shared/wire/bytes.hpp"

namespace sc::sim {
namespace {

/// Longer between two runs is a way between two lines, which takes as long as the axes need.
constexpr std::int64_t kSameLineNs = 20'000'000;

std::string text(const Sha256& hash) {
    const auto digits = to_hex(hash.digest());
    return {digits.begin(), digits.end()};
}

}  // namespace

void OutputHashes::tick(const ServoOutputs& outputs) {
    for (std::size_t i = 0; i < outputs.pulses_size; ++i) {
        const PathPulse& pulse = outputs.pulses[i];
        std::array<std::uint8_t, trace::kCommandRecordSize> bytes{};
        trace::pack(trace::CommandRecord{pulse.path, pulse.pass, pulse.number, pulse.s_pm, pulse.place_pm,
                                         pulse.energy_code, pulse.t_ns},
                    bytes);
        commands_.update(bytes);
    }
    for (std::size_t i = 0; i < outputs.laser_size; ++i) {
        const LaserRun& run = outputs.laser[i];
        const std::int64_t since = run.t0_ns - last_run_ns_;
        last_run_ns_ = run.t0_ns;
        std::array<std::uint8_t, 32> bytes{};
        ByteWriter writer(bytes);
        writer.put(since > kSameLineNs ? std::int64_t{0} : since);
        writer.put(run.period_ns256);
        writer.put(run.change_ns256);
        writer.put(run.count);
        writer.put(run.pick);
        writer.put(run.power);
        laser_.update(std::span(bytes).first(writer.size()));
    }
    if (static_cast<State>(outputs.state) == State::marking && outputs.set_point != before_) {
        before_ = outputs.set_point;
        std::array<std::uint8_t, 8 * kAxisCount> bytes{};
        ByteWriter writer(bytes);
        for (const std::int64_t place : before_) {
            writer.put(place);
        }
        set_points_.update(bytes);
    }
}

std::string OutputHashes::commands() const { return text(commands_); }
std::string OutputHashes::set_points() const { return text(set_points_); }
std::string OutputHashes::laser() const { return text(laser_); }

}  // namespace sc::sim
