// SPDX-License-Identifier: Apache-2.0
// What waits for the controller.
#include "firmware/link/endpoint.hpp"
#include "firmware/link/event_of.hpp"

namespace sc::link {
namespace {

/// The payload has been decoded once, so this cannot fail.
template <class... Message>
void read_body(MessageList<Message...> /*list*/, LinkEvent::Kind kind, std::span<const std::uint8_t> payload,
               LinkEvent& out) noexcept {
    const auto read = [&]<class M>(const M* /*type*/) noexcept {
        return kind == EventOf<M>::kKind && (static_cast<void>(decode_payload(payload, out.*EventOf<M>::kBody)), true);
    };
    static_cast<void>((read(static_cast<const Message*>(nullptr)) || ...));
}

}  // namespace

bool Endpoint::poll(LinkEvent& out) noexcept {
    if (event_count_ == 0) {
        out.kind = LinkEvent::Kind::none;
        return false;
    }
    const Pending& event = events_[event_head_];
    out.kind = event.kind;
    read_body(RequestMessages{}, event.kind, std::span(event.payload).first(event.size), out);
    event_head_ = (event_head_ + 1) % kEvents;
    --event_count_;
    return true;
}

}  // namespace sc::link
