// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "shared/units/time.hpp"

namespace sc::host {

/// One heartbeat and its answer. Each stamp is on the safe side of what it stands for: the host has not sent later than
/// `sent` by more than it says, and so on; so however long the ways were, the clocks cannot contradict them.
struct ClockSample {
    HostTime sent;                      ///< not after the heartbeat left
    HostTime received;                  ///< not before the answer came
    std::int64_t cell_received_us = 0;  ///< not before the heartbeat came
    std::int64_t cell_sent_us = 0;      ///< not after the answer left
};

/// Where the cell's clock stands: cell time = host time + offset, `offset` changing by `rate` a second.
struct ClockEstimate {
    double offset_s = 0.0;       ///< at the time asked for
    double uncertainty_s = 0.0;  ///< the true offset is no further away
    double rate = 0.0;           ///< cell seconds a host second, less one
    double rate_uncertainty = 0.0;
    double round_trip_s = 0.0;     ///< shortest, without the time in the cell
    double inconsistency_s = 0.0;  ///< by how much the samples contradict two even clocks; in the uncertainty already
    std::size_t samples = 0;       ///< heard, since the clocks were last found to have jumped
    std::uint32_t restarts = 0;    ///< such jumps: another start of the cell, a host that was suspended
};

/// Offset and rate between two clocks by the smallest delays of each way. A heartbeat says that the cell's clock was at
/// most so much at its sending, an answer that it was at least so much at its coming: of all lines (offset, rate) those
/// that no sample contradicts are left, and with them hard bounds for any time. Long delays cut nothing off, so no
/// distribution of delays is assumed; asymmetry of the shortest ones is what the uncertainty is made of. (The bounds
/// are those of Marzullo's and Owicki's intervals, with a rate: a linear programme in two unknowns, solved on its
/// rate.)
///
/// Keeps the tightest sample each way of every half second of the last minute. Rates differ by 500 ppm at most, and
/// change by 1e-8 a second at most.
class ClockFit {
public:
    static constexpr double kRateMost = 500e-6;
    static constexpr double kRateChange = 1e-8;  ///< 1/s
    static constexpr double kJump = 20e-3;       ///< s: contradictions beyond are another clock
    static constexpr Nanoseconds kBin{500'000'000};
    static constexpr std::size_t kBins = 120;

    void add(const ClockSample& sample);
    void clear() { *this = ClockFit(); }
    /// nullopt before the first sample. Any time; beyond the samples the uncertainty grows with that of the rate.
    [[nodiscard]] std::optional<ClockEstimate> at(HostTime time) const;
    /// The host's time at which the cell's clock showed `cell_us`, by the estimate; nullopt before the first sample.
    [[nodiscard]] std::optional<HostTime> host_time(std::uint64_t cell_us) const;

private:
    /// offset ≤ (or ≥) bound, at a time.
    struct Bound {
        HostTime at;
        double offset_s = 0.0;
    };
    struct Bin {
        Bound upper;
        Bound lower;
    };
    struct Lines;
    [[nodiscard]] Lines lines(HostTime reference) const;
    void insert(const ClockSample& sample);

    std::deque<Bin> bins_;
    double round_trip_s_ = 0.0;
    std::size_t samples_ = 0;
    std::uint32_t restarts_ = 0;
};

}  // namespace sc::host
