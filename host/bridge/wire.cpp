// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/wire.hpp"

#include <span>

#include "shared/link/codec.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kChunk = 4096;

}  // namespace

std::size_t Wire::receive(HostTime until, const std::function<void(const CellMessage&)>& handle) {
    std::array<std::uint8_t, kChunk> bytes{};
    const std::size_t n = transport_->receive(bytes, until);
    std::size_t taken = 0;
    receiver_.receive(std::span(bytes).first(n), [&](const link::Envelope& envelope) {
        // The answer to a handshake begins a new count, whatever came before.
        if (envelope.id == link::HelloReply::kId) {
            watch_.restart(envelope.counter);
        } else if (!watch_.take(envelope.counter)) {
            return;
        }
        const auto hand_on = [&](const auto& message) {
            ++taken;
            handle(message);
        };
        if (link::dispatch(link::CellMessages{}, envelope, hand_on) != link::Dispatch::handled) {
            ++malformed_;
        }
    });
    received_ += taken;
    return taken;
}

WireCounters Wire::counters() const noexcept {
    return {.sent = sent_,
            .received = received_,
            .malformed = malformed_,
            .frames_bad = receiver_.frames_bad(),
            .messages_lost = watch_.lost(),
            .messages_repeated = watch_.repeated()};
}

}  // namespace sc::host
