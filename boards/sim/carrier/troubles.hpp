// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>
#include <span>
#include <vector>

namespace sc::sim {

/// What befalls frames (CAN) or messages (serial), as shares of all; each is drawn for itself.
struct TroubleRates {
    double destroy = 0.0;  ///< on the wire; on CAN all see it, and the controller sends it again
    double lose = 0.0;     ///< by its receiver alone
    double repeat = 0.0;   ///< comes twice
    double late = 0.0;     ///< by up to `late_ns`, order kept
    double swap = 0.0;     ///< overtaken by the next one
    double spoil = 0.0;    ///< handed over with a wrong byte
    std::int64_t late_ns = 3'000'000;
};

/// The line is cut between two times.
struct Partition {
    std::int64_t from_ns = 0;
    std::int64_t until_ns = 0;
};

/// Draws the troubles of a carrier, from a seed.
class Troubles {
public:
    Troubles() = default;
    Troubles(const TroubleRates& rates, std::vector<Partition> partitions, std::uint64_t seed)
        : rates_(rates), partitions_(std::move(partitions)), random_(seed) {}

    [[nodiscard]] const TroubleRates& rates() const noexcept { return rates_; }
    [[nodiscard]] bool chance(double share);
    /// Evenly from 0 to `most`.
    [[nodiscard]] std::int64_t up_to(std::int64_t most);
    [[nodiscard]] bool cut(std::int64_t now_ns) const noexcept;
    /// Changes one byte.
    void spoil(std::span<std::uint8_t> bytes);

private:
    TroubleRates rates_;
    std::vector<Partition> partitions_;
    std::mt19937_64 random_{1};
};

}  // namespace sc::sim
