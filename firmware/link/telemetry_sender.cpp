// SPDX-License-Identifier: Apache-2.0
#include "firmware/link/telemetry_sender.hpp"

#include "shared/wire/bytes.hpp"

namespace sc::link {
namespace {

constexpr std::int64_t kUnknownChannel = 1;
constexpr std::int64_t kNoPeriod = 2;

bool periods_sound(const TelemetryRequest& request) noexcept {
    for (std::size_t g = 0; g < TelemetryRequest::kGroups; ++g) {
        const bool wanted = (request.channels & telemetry_group_bits(static_cast<TelemetryGroup>(g))) != 0;
        const std::uint16_t ticks = request.period_ticks[g];
        if (wanted && (ticks < kTelemetryShortest || ticks > kTelemetryLongest)) {
            return false;
        }
    }
    return true;
}

}  // namespace

Refusal TelemetrySender::subscribe(const TelemetryRequest& request, std::uint32_t period_ns, std::int64_t tick,
                                   std::int64_t& detail) noexcept {
    if ((request.channels & ~kTelemetryChannels) != 0) {
        detail = kUnknownChannel;
        return Refusal::bad_config;
    }
    if (!periods_sound(request)) {
        detail = kNoPeriod;
        return Refusal::bad_config;
    }
    const std::uint32_t budget = telemetry_budget(request.line_bytes_per_s);
    if (telemetry_bytes_per_s(request, period_ns, kTelemetryShortest) > budget) {
        detail = telemetry_fitting_period(request, period_ns);
        return Refusal::telemetry_over_budget;
    }
    channels_ = request.channels;
    due_ = 0;
    period_ = request.period_ticks;
    next_.fill(tick);
    skipped_ = 0;
    per_tick_ = std::uint64_t{budget} * kTelemetryPart * kParts * period_ns / 1'000'000'000U;
    on_its_way_ = 0;
    return Refusal::none;
}

void TelemetrySender::step(std::int64_t tick, std::size_t bytes) noexcept {
    if (channels_ == 0) {
        return;
    }
    on_its_way_ = (on_its_way_ > per_tick_ ? on_its_way_ - per_tick_ : 0) + bytes * kParts;
    for (std::size_t g = 0; g < TelemetryRequest::kGroups; ++g) {
        const std::uint32_t bits = channels_ & telemetry_group_bits(static_cast<TelemetryGroup>(g));
        if (bits == 0 || tick < next_[g]) {
            continue;
        }
        skipped_ = static_cast<std::uint16_t>(skipped_ + ((due_ & bits) != 0 ? 1U : 0U));
        due_ |= bits;
        next_[g] = tick + period_[g];
    }
}

Telemetry TelemetrySender::message(const TelemetryValues& values, std::uint64_t cell_time_us) const noexcept {
    Telemetry message;
    message.channels = due_;
    message.cell_time_us = cell_time_us;
    message.skipped = skipped_;
    ByteWriter writer(message.values.data);
    const auto put = [&](TelemetryChannel channel, const auto& value) noexcept {
        if ((due_ & telemetry_bit(channel)) != 0) {
            codec_detail::put_field(writer, value);
        }
    };
    put(TelemetryChannel::set_point, values.set_point);
    put(TelemetryChannel::actual, values.actual);
    put(TelemetryChannel::following_error, values.following_error);
    put(TelemetryChannel::state, values.state);
    put(TelemetryChannel::first_fault, values.first_fault);
    put(TelemetryChannel::limited_by, values.limited_by);
    put(TelemetryChannel::override_percent, values.override_percent);
    put(TelemetryChannel::flags, values.flags);
    put(TelemetryChannel::queue, values.queue);
    put(TelemetryChannel::pulses, values.pulses);
    put(TelemetryChannel::starvations, values.starvations);
    put(TelemetryChannel::frames_bad, values.frames_bad);
    put(TelemetryChannel::messages_lost, values.messages_lost);
    put(TelemetryChannel::y_sensor, values.y_sensor);
    put(TelemetryChannel::surface_depth, values.surface_depth);
    put(TelemetryChannel::shift, values.shift);
    put(TelemetryChannel::triple, values.triple);
    message.values.size = static_cast<std::uint8_t>(writer.size());
    return message;
}

void TelemetrySender::sent(std::size_t bytes) noexcept {
    on_its_way_ += bytes * kParts;
    due_ = 0;
}

}  // namespace sc::link
