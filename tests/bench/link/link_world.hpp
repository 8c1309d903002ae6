// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "host/bridge/transport.hpp"
#include "tests/bench/link/carriers.hpp"
#include "tests/bench/link/cell_end.hpp"

namespace sc::bench {

/// Host, carrier and controller in one virtual time: the host's transport is the world, which lives on while the host
/// waits. A host that is killed finds its transport closed, so that nothing more of it reaches the cell.
class LinkWorld final : public host::Transport {
public:
    LinkWorld(Carrier& carrier, CellEnd& cell) : carrier_(&carrier), cell_(&cell) {}

    /// Times at which one side loses everything, rising.
    std::vector<std::int64_t> host_kills_ns{};
    std::vector<std::int64_t> cell_resets_ns{};

    void send(std::span<const std::uint8_t> bytes) override {
        if (!dead_) {
            carrier_->send(0, bytes, now_ns_);
        }
    }
    std::size_t receive(std::span<std::uint8_t> out, HostTime until) override {
        while (arrived_.empty() && now() < until && !dead_) {
            step();
        }
        const std::size_t count = std::min(out.size(), arrived_.size());
        std::copy_n(arrived_.begin(), count, out.begin());
        arrived_.erase(arrived_.begin(), arrived_.begin() + static_cast<std::ptrdiff_t>(count));
        return count;
    }
    [[nodiscard]] HostTime now() const override { return HostTime{Nanoseconds(now_ns_)}; }
    [[nodiscard]] bool closed() const override { return dead_; }
    /// Time on the wire, from the first to the last point burnt, of all that the cell said meanwhile.
    [[nodiscard]] std::int64_t cell_said_ns() const { return cell_said_at_last_ns_ - cell_said_at_first_ns_; }

    /// Called once, at that time.
    void when_reached(std::int64_t at_ns, std::function<void()> call) {
        call_ns_ = at_ns;
        call_ = std::move(call);
    }
    /// The host is away.
    void live_alone(std::int64_t ns) {
        dead_ = false;
        carrier_->reset(0);
        for (const std::int64_t end = now_ns_ + ns; now_ns_ < end;) {
            step_cell();
        }
        arrived_.clear();
    }

private:
    static constexpr std::int64_t kStepNs = 250'000;
    static constexpr std::int64_t kTickNs = 1'000'000;

    void step_cell() {
        now_ns_ += kStepNs;
        if (resets_ < cell_resets_ns.size() && now_ns_ >= cell_resets_ns[resets_]) {
            ++resets_;
            carrier_->reset(1);
            cell_->reset();
        }
        if (call_ && now_ns_ >= call_ns_) {
            std::exchange(call_, {})();
        }
        if (now_ns_ % kTickNs == 0) {
            in_.clear();
            out_.clear();
            carrier_->receive(1, now_ns_, in_);
            cell_->tick(now_ns_ / kTickNs, in_, out_);
            carrier_->send(1, out_, now_ns_);
            count_said();
        }
    }
    void count_said() {
        const std::int64_t tick = now_ns_ / kTickNs;
        if (cell_->first_burn_tick() == tick) {
            cell_said_at_first_ns_ = cell_said_ns_;
        }
        cell_said_ns_ += out_.empty() ? 0 : carrier_->message_ns(out_);
        if (cell_->last_burn_tick() == tick) {
            cell_said_at_last_ns_ = cell_said_ns_;
        }
    }
    void step() {
        step_cell();
        if (kills_ < host_kills_ns.size() && now_ns_ >= host_kills_ns[kills_]) {
            ++kills_;
            dead_ = true;
            return;
        }
        carrier_->receive(0, now_ns_, arrived_);
    }

    Carrier* carrier_;
    CellEnd* cell_;
    std::int64_t now_ns_ = 0;
    std::vector<std::uint8_t> in_;
    std::vector<std::uint8_t> out_;
    std::vector<std::uint8_t> arrived_;
    std::int64_t cell_said_ns_ = 0;
    std::int64_t cell_said_at_first_ns_ = 0;
    std::int64_t cell_said_at_last_ns_ = 0;
    std::int64_t call_ns_ = 0;
    std::function<void()> call_;
    std::size_t kills_ = 0;
    bool dead_ = false;
    std::size_t resets_ = 0;
};

}  // namespace sc::bench
