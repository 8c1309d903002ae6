// SPDX-License-Identifier: Apache-2.0
#include "boards/replay/replayer.hpp"

#include <array>
#include <chrono>

#include "shared/link/seal.hpp"
#include "shared/trace/trace.hpp"

namespace sc::replay {
namespace {

using recording::LogEnd;

std::string hexadecimal(const Sha256& hash) {
    const auto digits = to_hex(hash.digest());
    return {digits.begin(), digits.end()};
}

Difference difference_of(std::int64_t tick, const recording::OutputsDigest& recorded,
                         const recording::OutputsDigest& replayed) {
    Difference difference{tick, recorded, replayed, {}};
    for (std::size_t part = 0; part < recording::kOutputParts; ++part) {
        if (recorded.check[part] != replayed.check[part]) {
            difference.parts.push_back(static_cast<recording::OutputPart>(part));
        }
    }
    return difference;
}

}  // namespace

Replayer::Replayer(std::span<const std::uint8_t> log, const ReplayOptions& options)
    : options_(options), reader_(log), problem_(reader_.end()) {
    if (problem_ == LogEnd::none) {
        controller_.emplace(reader_.header().machine, reader_.header().boot_id, options_.paint);
        if (reader_.header().sealed && options_.key) {
            controller_->fit_key({*options_.key, reader_.header().entropy});
        }
    }
}

bool Replayer::lacks_key() const noexcept {
    const recording::LogHeader& header = reader_.header();
    return header.sealed && (!options_.key || link::seal_key_check(*options_.key) != header.key_check);
}

void Replayer::run_tick(ReplayResult& result) {
    const ServoInputs& inputs = tick_.stored.inputs;
    outputs_ = &controller_->tick(inputs, reader_.header().plan_units);
    const recording::OutputsDigest digest = digester_.digest(*outputs_);
    images_.update(digester_.image());
    inner_.add(controller());
    for (const PathPulse& pulse : std::span(outputs_->pulses).first(outputs_->pulses_size)) {
        std::array<std::uint8_t, trace::kCommandRecordSize> bytes{};
        trace::pack(trace::CommandRecord{pulse.path, pulse.pass, pulse.number, pulse.s_pm, pulse.place_pm,
                                         pulse.energy_code, pulse.t_ns},
                    bytes);
        commands_.update(bytes);
    }
    result.pulses += outputs_->pulses_size;
    result.first_tick = result.ticks == 0 ? inputs.tick : result.first_tick;
    result.last_tick = inputs.tick;
    ++result.ticks;
    if (digest != tick_.digest) {
        result.difference = difference_of(inputs.tick, tick_.digest, digest);
    }
    if (options_.on_tick) {
        options_.on_tick(inputs, *outputs_);
    }
}

ReplayResult Replayer::run() {
    ReplayResult result;
    const auto begun = std::chrono::steady_clock::now();
    bool reached = false;
    while (!result.difference && !reached && reader_.next(tick_)) {
        run_tick(result);
        reached = options_.until && result.last_tick >= *options_.until;
    }
    result.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    result.cell_seconds =
        static_cast<double>(result.ticks) * static_cast<double>(reader_.header().machine.control_period_ns) * 1e-9;
    result.end = reader_.end();
    result.end_offset = reader_.offset();
    result.command_trace_sha256 = hexadecimal(commands_);
    result.outputs_sha256 = hexadecimal(images_);
    result.inner_sha256 = inner_.hexadecimal();
    if (controller_) {
        result.first_fault = controller().first_fault();
    }
    return result;
}

}  // namespace sc::replay
