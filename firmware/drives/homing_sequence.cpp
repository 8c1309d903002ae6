// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/homing_sequence.hpp"

namespace sc::drives {
namespace {

constexpr canopen::ObjectKey kModeObject{.index = 0x6060, .sub = 0, .size = 1};
constexpr canopen::ObjectKey kModeDisplay{.index = 0x6061, .sub = 0, .size = 1};

}  // namespace

void ModeChange::begin(axis402::Mode mode, SdoClient& sdo) noexcept {
    mode_ = mode;
    reads_left_ = kReads;
    written_ = false;
    sdo.write(kModeObject, static_cast<std::uint8_t>(mode));
}

ModeChange::Result ModeChange::step(SdoClient& sdo) noexcept {
    switch (sdo.result()) {
        case SdoClient::Result::busy: return Result::busy;
        case SdoClient::Result::idle:
        case SdoClient::Result::aborted:
        case SdoClient::Result::timed_out: return Result::failed;
        case SdoClient::Result::done: break;
    }
    if (written_ && sdo.value() == static_cast<std::uint8_t>(mode_)) {
        sdo.cancel();
        return Result::done;
    }
    if (reads_left_ == 0) {
        return Result::failed;
    }
    written_ = true;
    --reads_left_;
    sdo.read(kModeDisplay);
    return Result::busy;
}

void HomingSequence::step(const Input& input, SdoClient& sdo) noexcept {
    if (!input.wanted) {
        done_ = false;
        failed_ = false;
    }
    if (input.new_status && statuses_ < UINT8_MAX) {
        ++statuses_;
    }
    ++ticks_;
    const bool powered = input.power == axis402::PowerState::operation_enabled;
    switch (phase_) {
        case Phase::rest:
            if (input.wanted && powered && !done_ && !failed_) {
                begin(sdo);
            }
            break;
        case Phase::to_homing: {
            const ModeChange::Result result = change_.step(sdo);
            if (result == ModeChange::Result::failed || !input.wanted || !powered) {
                broken_off_ = !input.wanted;
                go_back(sdo);
            } else if (result == ModeChange::Result::done) {
                phase_ = Phase::running;
                statuses_ = 0;
                ticks_ = 0;
            }
            break;
        }
        case Phase::running: run(input, sdo); break;
        case Phase::breaking_off: break_off(input, sdo); break;
        case Phase::back: {
            const ModeChange::Result result = change_.step(sdo);
            stuck_ = result == ModeChange::Result::failed;
            if (result == ModeChange::Result::done) {
                phase_ = Phase::settling;
                statuses_ = 0;
            }
            break;
        }
        case Phase::settling:
            // Bit 12 means something else in homing mode: wait for statuswords that are surely of CSP.
            if (statuses_ >= kStaleStatuses) {
                finish();
            }
            break;
    }
}

void HomingSequence::begin(SdoClient& sdo) noexcept {
    phase_ = Phase::to_homing;
    homed_ = false;
    attained_ = false;
    broken_off_ = false;
    change_.begin(axis402::Mode::homing, sdo);
}

void HomingSequence::run(const Input& input, SdoClient& sdo) noexcept {
    if (input.power != axis402::PowerState::operation_enabled) {
        go_back(sdo);
        return;
    }
    if (!input.wanted || ticks_ > kLongestTicks) {
        broken_off_ = !input.wanted;
        phase_ = Phase::breaking_off;
        statuses_ = 0;
        ticks_ = 0;
        return;
    }
    if (!input.new_status || statuses_ <= kStaleStatuses) {
        return;
    }
    switch (axis402::decode_homing(input.statusword)) {
        case axis402::HomingState::done:
            attained_ = true;
            go_back(sdo);
            break;
        case axis402::HomingState::error: go_back(sdo); break;
        case axis402::HomingState::running:
        case axis402::HomingState::interrupted:
        case axis402::HomingState::attained_moving: break;
    }
}

void HomingSequence::break_off(const Input& input, SdoClient& sdo) noexcept {
    constexpr std::int64_t kLongestStopTicks = 2000;
    const bool at_rest = input.new_status && statuses_ > kStaleStatuses &&
                         axis402::decode_homing(input.statusword) != axis402::HomingState::running;
    if (at_rest || ticks_ > kLongestStopTicks || input.power != axis402::PowerState::operation_enabled) {
        go_back(sdo);
    }
}

void HomingSequence::go_back(SdoClient& sdo) noexcept {
    phase_ = Phase::back;
    change_.begin(axis402::Mode::csp, sdo);
}

void HomingSequence::finish() noexcept {
    phase_ = Phase::rest;
    homed_ = attained_;
    done_ = attained_;
    failed_ = !attained_ && !broken_off_;
}

}  // namespace sc::drives
