// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "link_host.hpp"
#include "shared/link/seal.hpp"

namespace sc::link {

inline constexpr crypto::Key kTestKey{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};

/// A host that has a key, step by step, and the clock of the endpoint that it talks to.
class SealHost {
public:
    explicit SealHost(Endpoint& endpoint, const crypto::Key& key = kTestKey) : endpoint_(&endpoint), key_(key) {}

    /// One tick: these bytes come, and the plan step has its share.
    void tick(std::span<const std::uint8_t> bytes = {}) {
        endpoint_->receive(++now, bytes);
        endpoint_->check_seals();
        plain.collect(*endpoint_);
    }
    void ticks(int count) {
        for (int i = 0; i < count; ++i) {
            tick();
        }
    }
    /// Asks for a challenge; false without one.
    bool ask(std::uint32_t session) {
        ++nonce_;
        request = {};
        request.session = session;
        request.nonce[0] = nonce_;
        plain.challenges.clear();
        tick(plain.framed(request));
        ticks(4);
        if (plain.challenges.empty()) {
            return false;
        }
        challenge = plain.challenges.back();
        transcript_.set(request, challenge.nonce, challenge.challenge);
        return true;
    }
    [[nodiscard]] bool cell_proves_itself() {
        const crypto::Block proof = crypto::cmac(crypto::CmacKey(key_), transcript_.of(SealUse::cell_proof));
        return crypto::same_tag(challenge.proof, proof);
    }
    SealHello hello(std::uint16_t first = 0) {
        SealHello message;
        message.session = request.session;
        message.challenge = challenge.challenge;
        message.first = first;
        message.proof = seal_tag(crypto::cmac(crypto::CmacKey(key_), transcript_.of(message)));
        return message;
    }
    /// Opens the session; the endpoint's event is taken.
    bool connect(std::uint32_t session = 7, std::uint16_t first = 0) {
        if (!ask(session)) {
            return false;
        }
        const SealHello message = hello(first);
        hello_bytes = plain.framed(message);
        plain.hellos.clear();
        tick(hello_bytes);
        ticks(4);
        session_key = crypto::CmacKey(crypto::cmac(crypto::CmacKey(key_), transcript_.of(SealUse::session_key)));
        counter = first;
        LinkEvent event;
        endpoint_->poll(event);
        return !plain.hellos.empty() && plain.hellos.back().refusal == 0;
    }
    template <class Message>
    std::vector<std::uint8_t> sealed(const Message& message, std::uint64_t number) const {
        std::vector<std::uint8_t> bytes(kSerialCapacity);
        bytes.resize(encode_sealed(message, number, session_key, bytes));
        return bytes;
    }
    template <class Message>
    std::vector<std::uint8_t> sealed(const Message& message) {
        return sealed(message, ++counter);
    }
    /// Whether a command came through to the controller.
    bool done(std::span<const std::uint8_t> bytes) {
        tick(bytes);
        ticks(6);
        LinkEvent event;
        const bool any = endpoint_->poll(event);
        return any && event.kind == LinkEvent::Kind::command;
    }
    Command command() { return {.sequence = ++sequence_, .verb = static_cast<std::uint8_t>(Verb::enable)}; }

    LinkHost plain;
    std::int64_t now = 1000;
    SealRequest request;
    SealChallenge challenge;
    std::vector<std::uint8_t> hello_bytes;
    crypto::CmacKey session_key;
    std::uint64_t counter = 0;

private:
    Endpoint* endpoint_;
    crypto::Key key_;
    SealTranscript transcript_;
    std::uint8_t nonce_ = 0;
    std::uint32_t sequence_ = 0;
};

}  // namespace sc::link
