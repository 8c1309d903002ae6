// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/drives/axis402.hpp"
#include "firmware/drives/sdo_client.hpp"

namespace sc::drives {

/// Writes 6060 and waits until 6061 shows the new mode: only that confirms the change.
class ModeChange {
public:
    enum class Result : std::uint8_t { busy, done, failed };
    void begin(axis402::Mode mode, SdoClient& sdo) noexcept;
    /// Once a tick.
    [[nodiscard]] Result step(SdoClient& sdo) noexcept;

private:
    static constexpr std::uint8_t kReads = 50;
    axis402::Mode mode_ = axis402::Mode::csp;
    std::uint8_t reads_left_ = 0;
    bool written_ = false;
};

/// Homing of one drive: change to homing mode, start, wait, change back to CSP. While `active`, the drive's target
/// follows its actual position, so that CSP is entered without a jump. Control tick; never blocks.
class HomingSequence {
public:
    struct Input {
        bool wanted = false;  ///< held by the caller until `done` or `failed`; withdrawing it breaks the homing off
        axis402::PowerState power = axis402::PowerState::unknown;
        std::uint16_t statusword = 0;
        bool new_status = false;  ///< a statusword has arrived since the last tick
    };
    void step(const Input& input, SdoClient& sdo) noexcept;
    /// The node has booted again: forgets everything, `homed` too.
    void clear() noexcept { *this = HomingSequence{}; }

    /// Not in CSP: on the way, running, or on the way back.
    [[nodiscard]] bool active() const noexcept { return phase_ != Phase::rest; }
    /// Bit 4 of the controlword.
    [[nodiscard]] bool start_bit() const noexcept { return phase_ == Phase::running; }
    /// Since `wanted` was raised: homed and back in CSP / given up and back in CSP.
    [[nodiscard]] bool done() const noexcept { return done_; }
    [[nodiscard]] bool failed() const noexcept { return failed_; }
    [[nodiscard]] bool homed() const noexcept { return homed_; }
    /// The drive does not change its mode: its set-up must be run again.
    [[nodiscard]] bool stuck() const noexcept { return stuck_; }

    /// After a start or a change of mode the drive may still show the bits of before for so many statuswords.
    static constexpr std::uint8_t kStaleStatuses = 4;
    static constexpr std::int64_t kLongestTicks = 60'000;

private:
    enum class Phase : std::uint8_t { rest, to_homing, running, breaking_off, back, settling };
    void begin(SdoClient& sdo) noexcept;
    void run(const Input& input, SdoClient& sdo) noexcept;
    void break_off(const Input& input, SdoClient& sdo) noexcept;
    void go_back(SdoClient& sdo) noexcept;
    void finish() noexcept;

    ModeChange change_{};
    std::int64_t ticks_ = 0;
    Phase phase_ = Phase::rest;
    std::uint8_t statuses_ = 0;
    bool attained_ = false;
    bool broken_off_ = false;
    bool done_ = false;
    bool failed_ = false;
    bool homed_ = false;
    bool stuck_ = false;
};

}  // namespace sc::drives
