// SPDX-License-Identifier: Apache-2.0
#include "firmware/link/seal_gate.hpp"

#include <algorithm>

namespace sc::link {

SealGate::SealGate() noexcept = default;

void SealGate::fit(const SealSecret& secret, std::uint32_t boot, std::uint32_t ticks_per_s) noexcept {
    cell_key_ = crypto::CmacKey(secret.key);
    ByteWriter draw(draw_);
    draw.put(static_cast<std::uint8_t>(SealUse::nonce));
    draw.put_bytes(secret.entropy);
    draw.put(boot);
    challenge_.blocks_per_s = kBlocksPerTick * ticks_per_s;
    fitted_ = true;
}

// --- servo step ---------------------------------------------------------------------------------------------------

/// Records do not reach over the end.
std::size_t SealGate::place(std::size_t at) const noexcept { return at >= kBytes || queue_[at] == kWrap ? 0 : at; }

void SealGate::push(const Envelope& envelope) noexcept {
    const std::size_t size = kRecordHead + envelope.payload.size();
    if (waiting_ + judged_ == 0) {
        head_ = tail_ = cursor_ = 0;
    }
    std::size_t at = head_;
    std::size_t room = head_ < tail_ ? tail_ - head_ - 1 : kBytes - head_;
    if (size > room && head_ >= tail_ && tail_ > size) {
        if (head_ < kBytes) {
            queue_[head_] = kWrap;
        }
        at = 0;
        room = tail_ - 1;
    }
    if (size > room) {
        drop();
        return;
    }
    ByteWriter out{std::span(queue_).subspan(at, size)};
    out.put(static_cast<std::uint8_t>(envelope.payload.size()));
    out.put(static_cast<std::uint8_t>(Verdict::waiting));
    out.put(std::uint64_t{envelope.counter});
    out.put(envelope.id);
    out.put_bytes(envelope.payload);
    head_ = at + size;
    ++waiting_;
}

bool SealGate::front(Checked& out) noexcept {
    for (; judged_ > 0; pop()) {
        tail_ = place(tail_);
        const auto verdict = static_cast<Verdict>(queue_[tail_ + kVerdictAt]);
        const std::span<const std::uint8_t> all = payload(tail_);
        ByteReader counter{std::span(queue_).subspan(tail_ + kCounterAt, 2)};
        out.envelope = {queue_[tail_ + kIdAt], counter.get<std::uint16_t>(), all};
        switch (verdict) {
            case Verdict::message:
                out.kind = Kind::message;
                out.envelope.payload = all.first(all.size() - kSealTag);
                return true;
            case Verdict::hello: out.kind = Kind::hello; return true;
            case Verdict::hello_again: out.kind = Kind::hello_again; return true;
            case Verdict::wrong: ++counters_.wrong; break;
            case Verdict::stale: ++counters_.stale; break;
            case Verdict::waiting:
            case Verdict::dropped: ++counters_.dropped; break;
        }
    }
    return false;
}

void SealGate::pop() noexcept {
    tail_ += kRecordHead + queue_[tail_ + kSizeAt];
    --judged_;
}

void SealGate::ask(const SealRequest& request) noexcept {
    if (request.session == asked_.session && request.nonce == asked_.nonce && (open_ || shake_ != Shake::idle)) {
        due_ = open_;  // repeated: its answer was lost, or is being made
        return;
    }
    asked_ = request;
    open_ = due_ = false;
    shake_ = Shake::nonce;
    drawing_ = false;
}

void SealGate::grant() noexcept {
    if (granted_ > 0) {
        end_session();  // the plan step had no time: its verdicts would fall at any tick
    }
    granted_ = kBlocksPerTick;
}

// --- plan step ----------------------------------------------------------------------------------------------------

void SealGate::work() noexcept {
    for (; granted_ > 0; --granted_) {
        step();
    }
}

/// A block of AES, or less.
void SealGate::step() noexcept {
    if (waiting_ > 0) {
        judge();
    } else if (shake_ != Shake::idle) {
        shake();
    }
}

void SealGate::judge() noexcept {
    cursor_ = place(cursor_);
    Verdict verdict = Verdict::waiting;
    if (!running_) {
        verdict = begin(cursor_);
    }
    if (verdict == Verdict::waiting) {
        verdict = compare(cursor_);
    }
    if (verdict == Verdict::waiting) {
        return;
    }
    running_ = hello_running_ = false;
    queue_[cursor_ + kVerdictAt] = static_cast<std::uint8_t>(verdict);
    cursor_ += kRecordHead + queue_[cursor_ + kSizeAt];
    --waiting_;
    ++judged_;
}

/// Waiting: its tag is to be checked.
SealGate::Verdict SealGate::begin(std::size_t at) noexcept {
    if (queue_[at + kIdAt] == SealHello::kId) {
        return begin_hello(at);
    }
    if (!live_) {
        return Verdict::dropped;
    }
    if (queue_[at + kSizeAt] < kSealTag) {
        return Verdict::wrong;
    }
    // As CounterWatch reads it: a little behind is late, everything else is ahead.
    constexpr std::uint16_t kLateWindow = 64;
    const auto field = std::span(queue_).subspan(at + kCounterAt, 8);
    const std::uint16_t low = ByteReader(field).get<std::uint16_t>();
    const auto newest = static_cast<std::uint16_t>(counter_ & 0xFFFFU);
    if (static_cast<std::uint16_t>(newest - low) < kLateWindow) {
        return Verdict::stale;
    }
    ByteWriter(field).put(counter_ + static_cast<std::uint16_t>(low - newest));
    run_.begin();
    running_ = true;
    return Verdict::waiting;
}

SealGate::Verdict SealGate::begin_hello(std::size_t at) noexcept {
    if (!decode_payload(payload(at), hello_)) {
        return Verdict::wrong;
    }
    if (live_ && hello_.challenge == accepted_.challenge && hello_.session == accepted_.session &&
        hello_.proof == accepted_.proof) {
        return Verdict::hello_again;
    }
    if (!open_ || hello_.challenge != challenge_.challenge || hello_.session != asked_.session) {
        return Verdict::wrong;
    }
    run_.begin();
    running_ = hello_running_ = true;
    return Verdict::waiting;
}

/// One block of the message's CMAC; behind the last one, what it says.
SealGate::Verdict SealGate::compare(std::size_t at) noexcept {
    if (hello_running_) {
        if (!run_.step(cell_key_, transcript_.of(hello_))) {
            return Verdict::waiting;
        }
        if (!open_ || !crypto::same_tag(hello_.proof, run_.tag())) {
            return Verdict::wrong;
        }
        open_session();
        return Verdict::hello;
    }
    const std::size_t size = queue_[at + kSizeAt] - kSealTag;
    if (!run_.step(session_key_, std::span(queue_).subspan(at + kCounterAt, kSealHead + size))) {
        return Verdict::waiting;
    }
    if (!live_) {
        return Verdict::dropped;
    }
    if (!crypto::same_tag(payload(at).subspan(size), run_.tag())) {
        return Verdict::wrong;
    }
    counter_ = ByteReader(std::span(queue_).subspan(at + kCounterAt, 8)).get<std::uint64_t>();
    return Verdict::message;
}

/// A challenge opens one session: said again, its hello must not set the counter back.
void SealGate::open_session() noexcept {
    session_key_ = crypto::CmacKey(next_key_);
    counter_ = hello_.first;
    accepted_ = hello_;
    open_ = due_ = false;
    live_ = true;
}

/// One block of what a challenge is made of.
void SealGate::shake() noexcept {
    if (!drawing_) {
        draw_run_.begin();
        drawing_ = true;
        if (shake_ == Shake::nonce) {
            ++challenge_.challenge;
            ByteWriter(std::span(draw_).last<4>()).put(challenge_.challenge);
        }
    }
    switch (shake_) {
        case Shake::nonce:
            if (draw_run_.step(cell_key_, draw_)) {
                challenge_.nonce = draw_run_.tag();
                challenge_.session = asked_.session;
                transcript_.set(asked_, challenge_.nonce, challenge_.challenge);
                shake_ = Shake::session_key;
                drawing_ = false;
            }
            break;
        case Shake::session_key:
            if (draw_run_.step(cell_key_, transcript_.of(SealUse::session_key))) {
                next_key_ = draw_run_.tag();
                shake_ = Shake::proof;
                drawing_ = false;
            }
            break;
        case Shake::proof:
            if (draw_run_.step(cell_key_, transcript_.of(SealUse::cell_proof))) {
                challenge_.proof = seal_tag(draw_run_.tag());
                shake_ = Shake::idle;
                drawing_ = false;
                open_ = due_ = true;
            }
            break;
        case Shake::idle: break;
    }
}

}  // namespace sc::link
