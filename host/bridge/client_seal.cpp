// SPDX-License-Identifier: Apache-2.0
// Sealed sessions, the host's side: challenge and answer (shared/link/seal.hpp), and what a controller has time to
// check.
#include <algorithm>
#include <array>

#include "host/bridge/client.hpp"
#include "host/bridge/key_file.hpp"
#include "host/bridge/open_transport.hpp"
#include "shared/link/blocks.hpp"
#include "shared/link/schema.hpp"

namespace sc::host {
namespace {

/// A hello that no controller without a key accepts: it changes nothing, and tells what answers.
constexpr std::uint16_t kNoTimeout = 0;
/// What may go out at once: two blocks of items.
constexpr std::int64_t kBurstBlocks = 32;

Refusal refusal_of(const link::HelloReply& reply) { return static_cast<Refusal>(reply.refusal); }

}  // namespace

ClientOptions client_options(const LinkOptions& link, std::uint32_t session) {
    ClientOptions options;
    options.session = session;
    if (link.key) {
        options.key = read_key_file(*link.key);
    }
    return options;
}

/// Never an unsealed session: whether the controller has a key shows in what it refuses.
void CellClient::shake_hands_sealed() {
    wire_.set_minor(link::kProtocolMinor);
    say_hello(kNoTimeout);
    const Refusal why = refusal_of(hello_);
    if (why != Refusal::seal_required) {
        const bool known = why != Refusal::schema_mismatch || link::minor_of(hello_.schema);
        if (known && hello_.major == link::kProtocolMajor && why != Refusal::wrong_state) {
            hello_.refusal = static_cast<std::uint16_t>(Refusal::seal_not_fitted);
        }
        return;
    }
    const crypto::CmacKey key(*options_.key);
    link::SealRequest request;
    request.session = options_.session;
    request.nonce = random_bytes();
    challenge_.reset();
    link::SealTranscript transcript;
    const auto proven = [&] {
        if (!challenge_ || challenge_->session != request.session) {
            return false;
        }
        transcript.set(request, challenge_->nonce, challenge_->challenge);
        return crypto::same_tag(challenge_->proof, crypto::cmac(key, transcript.of(link::SealUse::cell_proof)));
    };
    if (!repeat_until([&] { wire_.send(request); }, proven)) {
        if (!challenge_) {
            throw LinkError("the controller sends no challenge for a sealed session");
        }
        hello_.refusal = static_cast<std::uint16_t>(Refusal::seal_wrong_key);
        return;
    }
    link::SealHello hello;
    hello.session = options_.session;
    hello.challenge = challenge_->challenge;
    hello.heartbeat_timeout_ms = static_cast<std::uint16_t>(options_.heartbeat_timeout.count() / 1'000'000);
    hello.first = wire_.next_counter();
    hello.proof = link::seal_tag(crypto::cmac(key, transcript.of(hello)));
    const std::uint64_t first = wire_.next_position();
    hello_fresh_ = false;
    const auto taken = [this] {
        // A late answer to the first hello is none to this one.
        hello_fresh_ = hello_fresh_ && refusal_of(hello_) != Refusal::seal_required;
        return hello_fresh_;
    };
    if (!repeat_until([&] { wire_.send(hello); }, taken)) {
        throw LinkError("the controller does not answer to a sealed hello");
    }
    if (refusal_of(hello_) == Refusal::none) {
        wire_.seal(crypto::CmacKey(crypto::cmac(key, transcript.of(link::SealUse::session_key))), first);
    }
}

std::size_t CellClient::items_capacity() const noexcept {
    return options_.key ? link::kSealedItems : sizeof(link::Bytes::data);
}

/// A controller checks seals at its own pace, and drops what comes faster.
void CellClient::await_room() {
    if (!wire_.sealed() || !challenge_ || challenge_->blocks_per_s == 0) {
        return;
    }
    const auto blocks_last = [this](std::int64_t blocks) {
        return Nanoseconds(blocks * 1'000'000'000 / static_cast<std::int64_t>(challenge_->blocks_per_s));
    };
    checked_until_ = std::max(checked_until_, now()) + blocks_last(static_cast<std::int64_t>(wire_.take_seal_blocks()));
    const Nanoseconds burst = blocks_last(kBurstBlocks);
    while (checked_until_ > now() + burst) {
        pump(checked_until_ - burst);
    }
}

}  // namespace sc::host
