// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/crypto/cmac.hpp"
#include "shared/link/codec.hpp"
#include "shared/link/later_messages.hpp"
#include "shared/link/seal.hpp"

namespace sc::link {

/// What a board gives to a controller whose host commands are to be sealed.
struct SealSecret {
    crypto::Key key{};                       ///< shared with the hosts
    std::array<std::uint8_t, 16> entropy{};  ///< random, another at each start of the controller; need not be secret
};

/// What has been turned away, monotonic.
struct SealCounters {
    std::uint32_t wrong = 0;    ///< tag or proof is not right, or an answer to no open challenge
    std::uint32_t stale = 0;    ///< the counter had passed already
    std::uint32_t dropped = 0;  ///< no session to check them by, or no room to keep them
};

/// Keeps the messages of a sealed session until their tags have been checked (shared/link/seal.hpp has the rules), and
/// opens such sessions. The servo step puts messages in and takes out those that are good, in order; the plan step
/// checks them, kBlocksPerTick blocks of AES a tick. What a tick's share suffices for is taken in the next tick, so
/// the verdict falls at the same tick on every board; a plan step that was given no time ends the session instead.
///
/// Without a key nothing of it is called. No heap; some 1.8 kB.
class SealGate {
public:
    static constexpr std::uint32_t kBlocksPerTick = 5;
    static constexpr std::size_t kBytes = 1024;  ///< of messages that wait

    SealGate() noexcept;

    /// Once, before the first step.
    void fit(const SealSecret& secret, std::uint32_t boot, std::uint32_t ticks_per_s) noexcept;
    [[nodiscard]] bool fitted() const noexcept { return fitted_; }

    // --- servo step
    enum class Kind : std::uint8_t {
        message,
        hello,        ///< opens or resumes a session; its key is in force from here on
        hello_again,  ///< the one that did, repeated: nothing has changed
    };
    struct Checked {
        Kind kind = Kind::message;
        Envelope envelope;  ///< without the tag; valid until `pop`
    };
    /// The oldest message that is good. False: none has been checked. Others before it are dropped.
    [[nodiscard]] bool front(Checked& out) noexcept;
    void pop() noexcept;
    /// Whether there is a session by whose key messages can be checked.
    [[nodiscard]] bool live() const noexcept { return live_; }
    /// A new challenge is needed: nothing that was sealed before counts any more.
    void end_session() noexcept { live_ = false; }
    void ask(const SealRequest& request) noexcept;
    /// Of a session that is live, or a SealHello.
    void push(const Envelope& envelope) noexcept;
    void drop() noexcept { ++counters_.dropped; }
    /// Last in the tick: what the plan step is to do until the next.
    void grant() noexcept;
    /// To be sent; null when none is due.
    [[nodiscard]] const SealChallenge* due() const noexcept { return due_ ? &challenge_ : nullptr; }
    void sent() noexcept { due_ = false; }
    [[nodiscard]] const SealCounters& counters() const noexcept { return counters_; }

    // --- plan step
    void work() noexcept;

private:
    /// A message that waits: `kRecordHead` bytes, then its payload.
    enum class Verdict : std::uint8_t { waiting, message, hello, hello_again, wrong, stale, dropped };
    enum class Shake : std::uint8_t { idle, nonce, session_key, proof };
    static constexpr std::size_t kSizeAt = 0;     ///< u8, of the payload; kWrap: the next record is at the start
    static constexpr std::size_t kVerdictAt = 1;  ///< u8
    static constexpr std::size_t kCounterAt =
        2;  ///< u64, of which only the low 16 bits have come; then what is covered
    static constexpr std::size_t kIdAt = 10;
    static constexpr std::size_t kRecordHead = 11;
    static constexpr std::uint8_t kWrap = 0xFF;
    static_assert(kPayloadCapacity < kWrap && kIdAt - kCounterAt + 1 == kSealHead);

    [[nodiscard]] std::size_t place(std::size_t at) const noexcept;
    [[nodiscard]] std::span<std::uint8_t> payload(std::size_t at) noexcept {
        return std::span(queue_).subspan(at + kRecordHead, queue_[at + kSizeAt]);
    }
    void step() noexcept;
    void judge() noexcept;
    [[nodiscard]] Verdict begin(std::size_t at) noexcept;
    [[nodiscard]] Verdict begin_hello(std::size_t at) noexcept;
    [[nodiscard]] Verdict compare(std::size_t at) noexcept;
    void open_session() noexcept;
    void shake() noexcept;

    bool fitted_ = false;
    crypto::CmacKey cell_key_;
    std::array<std::uint8_t, 25> draw_{};  ///< what the next nonce is made over: use, entropy, start, number

    // Of the session.
    bool live_ = false;
    crypto::CmacKey session_key_;
    std::uint64_t counter_ = 0;  ///< of the newest message that was good
    SealHello accepted_;         ///< that opened it
    SealCounters counters_;

    // Of the challenge.
    Shake shake_ = Shake::idle;
    bool open_ = false;  ///< it waits for its hello
    bool due_ = false;
    SealRequest asked_;
    SealTranscript transcript_;
    crypto::Key next_key_{};
    SealChallenge challenge_;

    // Of the check that is under way.
    bool running_ = false;
    bool hello_running_ = false;
    SealHello hello_;
    crypto::CmacRun run_;
    bool drawing_ = false;  ///< a value of the challenge is under way
    crypto::CmacRun draw_run_;
    std::uint32_t granted_ = 0;

    std::array<std::uint8_t, kBytes> queue_{};
    std::size_t head_ = 0;       ///< where the next record goes
    std::size_t tail_ = 0;       ///< the oldest record
    std::size_t cursor_ = 0;     ///< the oldest that waits for its verdict
    std::uint32_t waiting_ = 0;  ///< records without a verdict
    std::uint32_t judged_ = 0;   ///< with one, not yet taken
};

}  // namespace sc::link
