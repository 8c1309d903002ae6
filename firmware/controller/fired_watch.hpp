// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/hal/retained.hpp"

namespace sc {

/// What of a job's pulses has left for certain, and what may have. The pulses of tick n leave in [t_n+1, t_n+2); so
/// when the power goes in that tick, those of n − 2 have left, those of n − 1 in part, those of n not. A fault of tick
/// n cancels what waits, and the guard may have shut the gate one window earlier: then n − 3 is certain. Servo context.
class FiredWatch {
public:
    /// A job is opened, with so much of it done. The record goes to `retained` at each change; it may be null.
    void begin(std::uint64_t job, std::uint32_t items, const JobPlace& done, RetainedMemory* retained) noexcept {
        record_ = {job, items, done, done};
        past_.fill(done);
        frozen_ = false;
        retained_ = retained;
        write();
    }
    /// Each tick, before its outputs are released: how far the job has come with them. `dark`: a fault, or what may
    /// become one, cancels what waits; nothing is burnt after that until a job begins.
    void tick(const JobPlace& now, bool dark) noexcept {
        if (record_.job == 0 || frozen_) {
            return;
        }
        const JobRecord before = record_;
        record_.reached = now;
        record_.certain = dark ? past_[2] : past_[1];
        frozen_ = dark;
        past_ = {now, past_[0], past_[1]};
        if (!(record_ == before)) {
            write();
        }
    }
    [[nodiscard]] const JobRecord& record() const noexcept { return record_; }

private:
    void write() noexcept {
        if (retained_ != nullptr) {
            retained_->write(record_);
        }
    }
    JobRecord record_;
    std::array<JobPlace, 3> past_{};  ///< after the last tick, the one before, and the one before that
    bool frozen_ = false;
    RetainedMemory* retained_ = nullptr;
};

}  // namespace sc
