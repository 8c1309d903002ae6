// SPDX-License-Identifier: Apache-2.0
// What a client learns beyond the state of its job: the cell's clock, telemetry, the black box.
#include <string>

#include "host/bridge/client.hpp"
#include "shared/link/telemetry.hpp"

namespace sc::host {

void CellClient::take(const link::ClockReply& message) {
    if (!connected_) {
        return;
    }
    const HostTime sent{Nanoseconds(static_cast<std::int64_t>(message.host_time_us) * 1000)};
    if (sent <= now() && sent >= connected_at_) {
        clock_.add(
            {sent, now(), static_cast<std::int64_t>(message.received_us), static_cast<std::int64_t>(message.sent_us)});
    }
}

void CellClient::take(const link::Telemetry& message) {
    if (on_telemetry_) {
        on_telemetry_(message);
    }
}

void CellClient::take(const link::BlackboxChunk& message) { blackbox_ = message; }

void CellClient::subscribe(const link::TelemetryRequest& wanted) {
    if (minor() < link::TelemetryRequest::kSince && wanted.channels == 0) {
        return;
    }
    require(link::TelemetryRequest::kSince, "send telemetry");
    link::TelemetryRequest message = wanted;
    const auto send = [&](std::uint32_t sequence) {
        message.sequence = sequence;
        wire_.send(message);
    };
    request(send, "subscribe to telemetry");
}

BlackBoxContent CellClient::read_black_box() {
    require(link::BlackboxRequest::kSince, "tell what its black box holds");
    BlackBoxContent content;
    for (const link::BlackboxPart part : {link::BlackboxPart::samples, link::BlackboxPart::events}) {
        link::BlackboxRequest wanted{static_cast<std::uint8_t>(part), 0};
        for (bool more = true; more;) {
            blackbox_.reset();
            const auto answered = [&] {
                return blackbox_ && blackbox_->part == wanted.part && blackbox_->first == wanted.first;
            };
            if (!repeat_until([&] { wire_.send(wanted); }, answered)) {
                throw LinkError("the cell does not tell what its black box holds");
            }
            const std::uint32_t next = take_chunk(*blackbox_, content);
            // Once round is enough of a box that still writes.
            more = next < blackbox_->end && next > wanted.first;
            wanted.first = next;
        }
    }
    return content;
}

}  // namespace sc::host
