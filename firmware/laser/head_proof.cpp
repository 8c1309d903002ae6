// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/head_proof.hpp"

namespace sc::laser {
namespace {

/// 2.5 % of the whole range, in 16-bit counts: nine times the usual limit of the acknowledge.
constexpr double kJumpCounts = 1638.0;
constexpr std::size_t kJumpFrame = 90;
constexpr std::uint16_t kRestTicks = 20;
/// A jump laid into the frames of tick n is seen by tick n + 2.
constexpr std::uint16_t kSeenTicks = 2;
constexpr std::uint16_t kArriveTicks = 20;
constexpr std::uint8_t kJumps = 4;

}  // namespace

void HeadProof::restart() noexcept {
    stage_ = Stage::rest;
    jump_ = 0;
    ticks_ = 0;
    out_ = false;
}

void HeadProof::next_jump() noexcept {
    ++jump_;
    ticks_ = 0;
    stage_ = jump_ == kJumps ? Stage::proven : Stage::jump;
}

void HeadProof::step(std::uint16_t status, std::span<GalvoFrame, kGalvoFramesPerTick> frames) noexcept {
    const bool z = jump_ >= 2;
    ++ticks_;
    switch (stage_) {
        case Stage::rest:
            if (status == kGalvoStatusOk) {
                stage_ = Stage::jump;
                ticks_ = 0;
            } else if (ticks_ > kRestTicks) {
                stage_ = Stage::failed;
            }
            break;
        case Stage::moving:
            if (ticks_ == kSeenTicks) {
                const std::uint16_t ack = z ? kGalvoAckZ : kGalvoAckX;
                stage_ = status == (kGalvoStatusOk & ~ack) ? Stage::arrive : Stage::failed;
                ticks_ = 0;
            }
            break;
        case Stage::arrive:
            if (status == kGalvoStatusOk) {
                next_jump();
            } else if (ticks_ > kArriveTicks) {
                stage_ = Stage::failed;
            }
            break;
        case Stage::jump:
        case Stage::proven:
        case Stage::failed: break;
    }
    const bool before = out_;
    if (stage_ == Stage::jump) {
        out_ = jump_ % 2 == 0;
        stage_ = Stage::moving;
        ticks_ = 0;
    } else if (stage_ == Stage::proven || stage_ == Stage::failed) {
        out_ = false;
    }
    if (before && out_) {
        displace(frames);
    } else if (before) {
        displace(frames.first<kJumpFrame>());
    } else if (out_) {
        displace(frames.last<kGalvoFramesPerTick - kJumpFrame>());
    }
}

void HeadProof::displace(std::span<GalvoFrame> frames) const noexcept {
    const bool z = jump_ >= 2;
    const auto way = static_cast<std::int32_t>(kJumpCounts * format_.scale());
    for (GalvoFrame& frame : frames) {
        std::uint32_t& word = z ? frame.word_z : frame.word_x;
        const std::int32_t from = format_.position(word);
        word = format_.word(from > 0 ? from - way : from + way);
    }
}

}  // namespace sc::laser
