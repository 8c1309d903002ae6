// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "shared/codes/codes.hpp"
#include "shared/link/blackbox.hpp"

namespace sc {

/// What the cell did in its last 10 s: how it stood every 40 ms, and what befell it. A fault freezes it with a last
/// sample of its own tick; `thaw` begins anew. Records have numbers from 0 on, so that a host can fetch them in any
/// pieces. Servo context; a sample costs some 200 instructions, an event 60. 8.8 kB.
class BlackBox {
public:
    static constexpr std::int64_t kSampleNs = 40'000'000;
    static constexpr std::uint32_t kSamples = 252;  ///< 10.04 s and the fault's own
    static constexpr std::uint32_t kEvents = 128;

    explicit BlackBox(std::int64_t period_ns) noexcept
        : period_ns_(period_ns > 0 ? period_ns : 1),
          sample_ticks_(kSampleNs / period_ns_ > 0 ? kSampleNs / period_ns_ : 1) {}

    [[nodiscard]] bool sample_due(std::int64_t tick) const noexcept {
        return !frozen_ && tick >= newest_tick_ + sample_ticks_;
    }
    /// `sample.tick` is filled in.
    void add(std::int64_t tick, link::BlackboxSample sample) noexcept;
    void note(std::int64_t tick, link::BlackboxKind kind, std::uint8_t a = 0, std::uint16_t b = 0) noexcept;
    /// Nothing is written any more; `last` is how the cell stands.
    void freeze(std::int64_t tick, Fault fault, std::uint8_t axis, const link::BlackboxSample& last) noexcept;
    void thaw() noexcept;
    [[nodiscard]] bool frozen() const noexcept { return frozen_; }
    /// Whole records from the number asked for on, as many as the message holds; none for a number that is not there.
    void read(const link::BlackboxRequest& request, link::BlackboxChunk& out) const noexcept;

private:
    std::int64_t period_ns_;
    std::int64_t sample_ticks_;
    std::int64_t newest_tick_ = -1'000'000'000;
    std::uint32_t samples_end_ = 0;
    std::uint32_t events_end_ = 0;
    bool frozen_ = false;
    Fault fault_ = Fault::none;
    std::uint8_t axis_ = 0xFF;
    std::array<std::array<std::uint8_t, link::BlackboxSample::kBytes>, kSamples> samples_{};
    std::array<std::array<std::uint8_t, link::BlackboxEvent::kBytes>, kEvents> events_{};
};

}  // namespace sc
