// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <random>
#include <vector>

#include "host/bridge/lock_step.hpp"
#include "host/bridge/transport.hpp"

namespace sc::host {

/// Carrier to a cell in lock-step virtual time. The clock is the cell's, so a run depends on nothing but its inputs and
/// the seed.
class LockStepTransport : public Transport {
public:
    struct Options {
        /// Each chunk sent reaches the cell up to this much later, drawn evenly; chunks keep their order.
        Nanoseconds jitter{0};
        std::uint64_t seed = 1;
        /// Longest stretch of virtual time in one exchange: how late the host may see what the cell said.
        Nanoseconds step{5'000'000};
    };
    /// `socket` stays the caller's.
    LockStepTransport(int socket, const Options& options);

    /// Takes on the time of a cell that has lived before. Before anything else.
    void learn_time();
    void send(std::span<const std::uint8_t> bytes) override;
    std::size_t receive(std::span<std::uint8_t> out, HostTime until) override;
    [[nodiscard]] HostTime now() const override { return lock_step_.now(); }
    [[nodiscard]] bool closed() const override { return closed_; }

private:
    struct Chunk {
        HostTime due;
        std::vector<std::uint8_t> bytes;
    };
    void step(HostTime until);
    [[nodiscard]] std::vector<std::uint8_t> take_due();
    [[nodiscard]] std::size_t take_received(std::span<std::uint8_t> out);

    LockStep lock_step_;
    Options options_;
    std::mt19937_64 random_;
    std::deque<Chunk> outgoing_;
    std::vector<std::uint8_t> received_;
    std::size_t taken_ = 0;
    int standstills_ = 0;
    bool closed_ = false;
};

}  // namespace sc::host
