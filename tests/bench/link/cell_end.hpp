// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "firmware/link/endpoint.hpp"
#include "shared/codes/state.hpp"

namespace sc::bench {

/// The controller's real endpoint with the least of a cell behind it: it does at once what it is told, and "burns" one
/// pulse at each point that comes. What it has burnt survives its resets, as the part does.
class CellEnd {
public:
    /// With a key it takes sealed commands only.
    explicit CellEnd(const link::EndpointOptions& options, std::uint32_t burns_per_tick,
                     const std::optional<crypto::Key>& key = std::nullopt)
        : options_(options), burns_per_tick_(burns_per_tick), key_(key) {
        reset();
    }

    /// Loses everything but the part and its retained memory.
    void reset();
    void tick(std::int64_t tick, std::span<const std::uint8_t> in, std::vector<std::uint8_t>& out);

    [[nodiscard]] const std::vector<PathPoint>& burnt() const noexcept { return burnt_; }
    void forget_burnt() { burnt_.clear(); }
    [[nodiscard]] std::int64_t first_burn_tick() const noexcept { return first_burn_tick_; }
    [[nodiscard]] std::int64_t last_burn_tick() const noexcept { return last_burn_tick_; }
    /// Points burnt in the first tick.
    [[nodiscard]] std::size_t burnt_at_first() const noexcept { return burnt_at_first_; }
    void forget_times() noexcept { first_burn_tick_ = -1; }
    [[nodiscard]] const link::Endpoint& endpoint() const noexcept { return *endpoint_; }
    [[nodiscard]] bool refused() const noexcept { return refused_; }

private:
    /// How far the job came: what the controller's own watch and retained memory hold.
    struct Record {
        std::uint64_t job = 0;
        std::uint32_t items = 0;
        std::uint32_t fired = 0;
        std::uint32_t path = 0;
        std::uint32_t pulses = 0;
    };
    void take(const link::LinkEvent& event);
    [[nodiscard]] Refusal decide(link::Verb verb);
    [[nodiscard]] link::Position position(std::uint32_t token) const;
    void burn(std::int64_t tick);

    link::EndpointOptions options_;
    std::uint32_t burns_per_tick_;
    std::optional<crypto::Key> key_;
    std::unique_ptr<link::Endpoint> endpoint_;
    std::uint32_t boot_ = 0;
    State state_ = State::disabled;
    bool homed_ = false;
    bool done_ = false;
    bool told_ = false;  ///< the record is of this start
    bool refused_ = false;
    Record record_;
    Record start_;            ///< of the job that is open
    std::uint32_t skip_ = 0;  ///< points of the first path that are burnt already
    std::int64_t tick_ = 0;
    std::int64_t first_burn_tick_ = -1;
    std::int64_t last_burn_tick_ = 0;
    std::size_t burnt_at_first_ = 0;
    std::vector<PathPoint> burnt_;
};

}  // namespace sc::bench
