// SPDX-License-Identifier: Apache-2.0
// The endpoint of a controller that has a key: nothing is taken before its seal has been checked.
#include "firmware/link/endpoint.hpp"

namespace sc::link {

void Endpoint::fit_key(const SealSecret& secret) noexcept {
    constexpr std::int64_t kSecondNs = 1'000'000'000;
    gate_.fit(secret, boot_id_, static_cast<std::uint32_t>(kSecondNs / control_period_ns_));
}

/// What the plan step has found good since the last tick; what it is to do next.
void Endpoint::take_checked() noexcept {
    for (SealGate::Checked checked; gate_.front(checked); gate_.pop()) {
        if (checked.kind == SealGate::Kind::message) {
            take(checked.envelope);
        } else {
            take_seal_hello(checked);
        }
    }
    if (gate_.live() && !alive(tick_)) {
        gate_.end_session();
    }
    gate_.grant();
}

void Endpoint::take_seal_hello(const SealGate::Checked& checked) noexcept {
    SealHello sealed;
    static_cast<void>(decode_payload(checked.envelope.payload, sealed));
    if (checked.kind == SealGate::Kind::hello_again) {
        answer_hello(sealed.session, Refusal::none);
        return;
    }
    Hello hello;
    hello.schema = kSchemaHash;
    hello.session = sealed.session;
    hello.heartbeat_timeout_ms = sealed.heartbeat_timeout_ms;
    payload_ = {};
    on_hello(hello, sealed.first);
}

/// Of what has only a right checksum: answers without taking anything from it, or keeps it to be checked.
void Endpoint::sift(const Envelope& envelope) noexcept {
    if (envelope.id == Hello::kId) {
        Hello hello;
        if (decode_payload(envelope.payload, hello)) {
            ++counters_.hellos_refused;
            answer_hello(hello.session,
                         hello.major != kProtocolMajor ? Refusal::version_mismatch : Refusal::seal_required);
        }
    } else if (envelope.id == SealRequest::kId) {
        SealRequest request;
        if (decode_payload(envelope.payload, request)) {
            gate_.ask(request);
        }
    } else if (envelope.id == SealHello::kId) {
        SealHello hello;
        if (decode_payload(envelope.payload, hello) && hello.session != session_ && alive(tick_)) {
            ++counters_.hellos_refused;
            answer_hello(hello.session, Refusal::wrong_state);
        } else {
            gate_.push(envelope);
        }
    } else if (gate_.live()) {
        gate_.push(envelope);
    } else {
        gate_.drop();
        refuse_expired();
    }
}

/// A host that has been silent, or that was here before the controller's start, learns that it must begin again.
void Endpoint::refuse_expired() noexcept {
    constexpr std::int64_t kEveryTicks = 20;
    if (tick_ >= next_expired_tick_ && !hello_reply_) {
        next_expired_tick_ = tick_ + kEveryTicks;
        answer_hello(session_, Refusal::seal_expired);
    }
}

bool Endpoint::send_challenge(Outbox& box) noexcept {
    if (const SealChallenge* due = gate_.due()) {
        const std::size_t size = encode_serial(*due, send_counter_, box.out.subspan(box.size), minor_);
        if (size == 0) {
            return false;
        }
        ++send_counter_;
        box.size += size;
        gate_.sent();
    }
    return true;
}

}  // namespace sc::link
