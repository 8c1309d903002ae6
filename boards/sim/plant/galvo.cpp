// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/galvo.hpp"

#include <bit>
#include <cmath>
#include <stdexcept>

namespace sc::sim {
namespace {

constexpr std::uint16_t kStatusGood = 0xFDFD;
/// Power OK and temperature OK of both halves of the status word are gone.
constexpr std::uint16_t kStatusPowerLost = 0x7D7D;
/// A mirror this near to its command, and this slow, is put there: the exponential never ends by itself.
constexpr double kRestPlace = 1e-13;
constexpr double kRestSpeed = 1e-9;

}  // namespace

std::optional<std::uint16_t> decode_xy2_100(std::uint32_t word) noexcept {
    const bool form = (word >> 17U) == 0b001U;
    if (!form || std::popcount(word) % 2 != 0) {
        return std::nullopt;
    }
    return static_cast<std::uint16_t>(word >> 1U);
}

std::optional<std::uint32_t> decode_xy2_100_18(std::uint32_t word) noexcept {
    if ((word >> 19U) != 1U || std::popcount(word) % 2 == 0) {
        return std::nullopt;
    }
    return (word >> 1U) & 0x3FFFFU;
}

std::array<double, 2> between(const Deflection& from, const Deflection& to, double fraction,
                              double frame_seconds) noexcept {
    const double u = fraction;
    const double w = 1.0 - u;
    std::array<double, 2> out{};
    for (std::size_t i = 0; i < 2; ++i) {
        out[i] = (1.0 + 2.0 * u) * w * w * from.place[i] + u * u * (3.0 - 2.0 * u) * to.place[i] +
                 frame_seconds * u * w * (w * from.speed[i] - u * to.speed[i]);
    }
    return out;
}

GalvoPlant::GalvoPlant(const MachineConfig& machine, const GalvoTruth& truth)
    : convention_(machine.galvo.convention),
      format_(machine.galvo.word),
      metres_per_count_(1.0 / machine.galvo.counts_per_metre / (format_ == GalvoWord::bits18 ? 4.0 : 1.0)),
      ack_limit_(truth.ack_limit) {
    const double frame = static_cast<double>(machine.galvo_period_ns) * 1e-9;
    const double lag = 2.0 * truth.damping / (2.0 * kPi * truth.natural_frequency);
    delay_ = truth.tracking - frame / 2.0 - lag;
    if (!(delay_ >= 0.0)) {
        throw std::invalid_argument("galvo: the servo alone is slower than tracking_us; raise natural_frequency_khz");
    }
    const double whole = std::floor(delay_ / frame);
    const double rest = delay_ - whole * frame;
    early_ = step_of(truth, rest);
    late_ = step_of(truth, frame - rest);
    line_.resize(static_cast<std::size_t>(whole) + 2);
}

GalvoPlant::Step GalvoPlant::step_of(const GalvoTruth& truth, double seconds) {
    const double omega = 2.0 * kPi * truth.natural_frequency;
    const double decay = truth.damping * omega;
    const double damped = omega * std::sqrt(1.0 - truth.damping * truth.damping);
    const double e = std::exp(-decay * seconds);
    const double c = std::cos(damped * seconds);
    const double s = std::sin(damped * seconds) / damped;
    return {e * (c + decay * s), e * s, -e * omega * omega * s, e * (c - decay * s)};
}

void GalvoPlant::take(std::size_t mirror, std::uint32_t word) {
    const bool wide = format_ == GalvoWord::bits18;
    const std::optional<std::uint32_t> code =
        wide ? decode_xy2_100_18(word)
             : decode_xy2_100(word).transform([](std::uint16_t c) { return std::uint32_t{c}; });
    if (!code) {
        ++dropped_;
        return;
    }
    word_[mirror] = word;
    const int range = wide ? 0x40000 : 0x10000;
    int counts = static_cast<int>(*code);
    if (convention_ != GalvoConvention::twos_complement) {
        counts -= range / 2;
    } else if (counts >= range / 2) {
        counts -= range;
    }
    const double place = metres_per_count_ * counts;
    if (place != command_[mirror]) {
        command_[mirror] = place;
        frames_unchanged_ = 0;
    }
}

void GalvoPlant::move(const Pair& command, const Step& step) {
    for (std::size_t i = 0; i < 2; ++i) {
        const double error = state_.place[i] - command[i];
        const double speed = state_.speed[i];
        state_.place[i] = command[i] + step.ee * error + step.ev * speed;
        state_.speed[i] = step.ve * error + step.vv * speed;
    }
}

bool GalvoPlant::settled() const noexcept {
    for (std::size_t i = 0; i < 2; ++i) {
        if (std::abs(state_.place[i] - command_[i]) > kRestPlace || std::abs(state_.speed[i]) > kRestSpeed) {
            return false;
        }
    }
    return frames_unchanged_ > line_.size();
}

void GalvoPlant::play(std::uint32_t word_x, std::uint32_t word_z) {
    if (failed_ || line_status_) {
        state_.speed = {};
        return;
    }
    ++frames_unchanged_;
    if (word_x != word_[0]) {
        take(0, word_x);
    }
    if (word_z != word_[1]) {
        take(1, word_z);
    }
    newest_ = (newest_ + 1) % line_.size();
    line_[newest_] = command_;
    if (settled()) {
        state_ = {command_, {}};
        return;
    }
    // Oldest first: the ring holds exactly the commands that are on their way, and the next one overwrites the oldest.
    const Pair& before = line_[(newest_ + 1) % line_.size()];
    const Pair& after = line_[(newest_ + 2) % line_.size()];
    move(before, early_);
    move(after, late_);
}

std::uint16_t GalvoPlant::status() const noexcept {
    if (line_status_) {
        return *line_status_;
    }
    if (failed_) {
        return kStatusPowerLost;
    }
    // Bit 4 of either byte: mirror Y of the standard, our z; bit 3: mirror x.
    constexpr unsigned kBytes = 0x0101;
    unsigned status = kStatusGood;
    for (std::size_t i = 0; i < 2; ++i) {
        if (std::abs(state_.place[i] - command_[i]) > ack_limit_) {
            status &= ~(kBytes << (i == 0 ? 3U : 4U));
        }
    }
    return static_cast<std::uint16_t>(status);
}

}  // namespace sc::sim
