// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/sim_transport.hpp"

#include <algorithm>

namespace sc::host {
namespace {

/// A cell runs whole ticks. Asked for less than one it may stand still; it is then asked for one more each time.
constexpr Nanoseconds kTick{1'000'000};
constexpr int kStandstillLimit = 1000;

}  // namespace

LockStepTransport::LockStepTransport(int socket, const Options& options)
    : lock_step_(socket), options_(options), random_(options.seed) {}

void LockStepTransport::learn_time() { closed_ = !lock_step_.exchange({}, Nanoseconds::zero(), received_); }

void LockStepTransport::send(std::span<const std::uint8_t> bytes) {
    if (closed_ || bytes.empty()) {
        return;
    }
    HostTime due = now();
    if (options_.jitter > Nanoseconds::zero()) {
        // Not std::uniform_int_distribution: its numbers differ between standard libraries.
        const auto range = static_cast<std::uint64_t>(options_.jitter.count()) + 1;
        due += Nanoseconds(static_cast<std::int64_t>(random_() % range));
    }
    if (!outgoing_.empty()) {
        due = std::max(due, outgoing_.back().due);
    }
    outgoing_.push_back({due, {bytes.begin(), bytes.end()}});
}

std::vector<std::uint8_t> LockStepTransport::take_due() {
    std::vector<std::uint8_t> due;
    while (!outgoing_.empty() && outgoing_.front().due <= now()) {
        due.insert(due.end(), outgoing_.front().bytes.begin(), outgoing_.front().bytes.end());
        outgoing_.pop_front();
    }
    return due;
}

void LockStepTransport::step(HostTime until) {
    const std::vector<std::uint8_t> due = take_due();
    HostTime target = std::min(until, now() + options_.step);
    if (!outgoing_.empty()) {
        target = std::min(target, outgoing_.front().due);
    }
    target += standstills_ * kTick;
    const HostTime before = now();
    closed_ = !lock_step_.exchange(due, target.time_since_epoch(), received_);
    standstills_ = now() > before ? 0 : standstills_ + 1;
    closed_ = closed_ || standstills_ > kStandstillLimit;
}

std::size_t LockStepTransport::take_received(std::span<std::uint8_t> out) {
    const std::size_t n = std::min(out.size(), received_.size() - taken_);
    std::copy_n(received_.begin() + static_cast<std::ptrdiff_t>(taken_), n, out.begin());
    taken_ += n;
    if (taken_ == received_.size()) {
        received_.clear();
        taken_ = 0;
    }
    return n;
}

std::size_t LockStepTransport::receive(std::span<std::uint8_t> out, HostTime until) {
    while (received_.empty() && now() < until && !closed_) {
        step(until);
    }
    return take_received(out);
}

}  // namespace sc::host
