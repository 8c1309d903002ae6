// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/watchdogs.hpp"

#include <cmath>

namespace sc::model {

using namespace watchdog_fields;

namespace {

constexpr std::uint32_t kLast = 0x40;  ///< of the window watchdog: below it, reset
constexpr double kUpdateCycles = 5;    ///< of LSI, until a register of the other domain is in force

std::int64_t after(std::int64_t now, double ns) { return now + static_cast<std::int64_t>(std::ceil(ns)); }

}  // namespace

WatchdogPair::WatchdogPair(Machine& machine, ClockTree& tree, double lsi_hz)
    : machine_(machine), tree_(tree), lsi_hz_(lsi_hz), independent_(*this), window_(*this) {
    machine.attach(kIwdg, 0x14, independent_);
    machine.attach(kWwdg, 0x0C, window_);
}

void WatchdogPair::reset(const std::string& why, std::int64_t ns, const Field& cause) {
    resets_.push_back({why, ns});
    tree_.preset(cause, 1);
    tree_.preset(clock_fields::kPinReset, 1);
    independent_.silence();
    window_.silence();
}

void WatchdogPair::Independent::settle() {
    const std::int64_t now = pair_.machine_.now_ns();
    prescaler_ = now >= prescaler_at_ ? next_prescaler_ : prescaler_;
    reload_ = now >= reload_at_ ? next_reload_ : reload_;
}

void WatchdogPair::Independent::load() {
    const double cycles = (reload_ + 1.0) * 4.0 * std::exp2(prescaler_);
    bites_at_ = pair_.lsi_runs_ ? after(pair_.machine_.now_ns(), cycles / pair_.lsi_hz_ * 1e9) : kNever;
}

std::uint32_t WatchdogPair::Independent::read(std::uint32_t offset) {
    settle();
    const std::int64_t now = pair_.machine_.now_ns();
    switch (offset) {
        case 0x04: return prescaler_;
        case 0x08: return reload_;
        case 0x0C: return (now < prescaler_at_ ? kPvu.mask() : 0U) | (now < reload_at_ ? kRvu.mask() : 0U);
        default: pair_.say("a register of IWDG that cannot be read"); return 0;
    }
}

void WatchdogPair::Independent::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    settle();
    if (!pair_.resets_.empty()) {
        return;
    }
    const std::int64_t now = pair_.machine_.now_ns();
    const bool lsi = runs_ && pair_.lsi_runs_;
    const std::int64_t updated = lsi ? after(now, kUpdateCycles / pair_.lsi_hz_ * 1e9) : kNever;
    if (bytes != 4) {
        return pair_.say("IWDG is written by parts");
    }
    if (offset == 0) {
        open_ = value == 0x5555;
        if (value == 0xCCCC && !runs_) {
            runs_ = true;
            load();
        } else if (value == 0xAAAA) {
            if (!runs_) {
                return pair_.say("IWDG is fed before it runs");
            }
            load();
        } else if (value != 0x5555) {
            pair_.say("IWDG gets a key that it does not know");
        }
        return;
    }
    if (!open_) {
        return pair_.say("a register of IWDG is written under its lock");
    }
    if (offset == 0x04 && (value & ~kPrescaler.mask()) == 0) {
        if (now < prescaler_at_) {
            pair_.say("PR is written while it is updated");
        }
        next_prescaler_ = value;
        prescaler_at_ = updated;
    } else if (offset == 0x08 && (value & ~kReload.mask()) == 0) {
        if (now < reload_at_) {
            pair_.say("RLR is written while it is updated");
        }
        next_reload_ = value;
        reload_at_ = updated;
    } else {
        pair_.say("IWDG has no such register or bit");
    }
}

double WatchdogPair::Window::count_ns() const {
    const double by = std::exp2((configuration_ & kTimeBase.mask()) >> kTimeBase.first);
    return 4096.0 * by / pair_.tree_.apb_hz(3) * 1e9;
}

std::uint32_t WatchdogPair::Window::counter() const {
    if (!active_) {
        return loaded_;
    }
    const double past = std::floor(static_cast<double>(pair_.machine_.now_ns() - loaded_at_) / count_ns());
    return loaded_ - static_cast<std::uint32_t>(past);
}

std::uint32_t WatchdogPair::Window::read(std::uint32_t offset) {
    if (!pair_.tree_.on(clock_fields::kWwdgEn)) {
        pair_.say("WWDG is read without its clock");
        return 0;
    }
    switch (offset) {
        case 0x00: return counter() | (active_ ? kActive.mask() : 0U);
        case 0x04: return configuration_;
        default: return flag_ ? kEarlyFlag.mask() : 0U;
    }
}

void WatchdogPair::Window::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (!pair_.resets_.empty()) {
        return;
    }
    if (bytes != 4) {
        return pair_.say("WWDG is written by parts");
    }
    if (!pair_.tree_.on(clock_fields::kWwdgEn) || !pair_.tree_.settled(clock_fields::kWwdgEn)) {
        return pair_.say("WWDG is written without its clock, or before it has settled");
    }
    switch (offset) {
        case 0x00: return write_control(value);
        case 0x04:
            if ((value & ~(kWindow.mask() | kEarly.mask() | kTimeBase.mask())) != 0) {
                pair_.say("a reserved bit of WWDG");
            }
            if ((configuration_ & kEarly.mask()) != 0 && (value & kEarly.mask()) == 0) {
                pair_.say("the warning of WWDG cannot be taken back");
            }
            configuration_ = value;
            return;
        default: flag_ = flag_ && (value & kEarlyFlag.mask()) != 0;
    }
}

void WatchdogPair::Window::write_control(std::uint32_t value) {
    if ((value & ~(kCounter.mask() | kActive.mask())) != 0) {
        pair_.say("a reserved bit of WWDG");
    }
    const std::int64_t now = pair_.machine_.now_ns();
    if (active_ && counter() > (configuration_ & kWindow.mask())) {
        return pair_.reset("window: fed too early", now, clock_fields::kWwdgReset);
    }
    if (active_ && (value & kActive.mask()) == 0) {
        pair_.say("WWDG cannot be stopped");
    }
    active_ = active_ || (value & kActive.mask()) != 0;
    loaded_ = value & kCounter.mask();
    loaded_at_ = now;
    if (!active_) {
        return;
    }
    if (!pair_.tree_.on(clock_fields::kWw1rsc)) {
        pair_.say("WWDG starts, and its reset reaches nothing");
    }
    if (loaded_ < kLast) {
        return pair_.reset("window: loaded below its end", now, clock_fields::kWwdgReset);
    }
    warns_at_ = loaded_ == kLast ? now : after(now, (loaded_ - kLast) * count_ns());
    bites_at_ = after(now, (loaded_ - kLast + 1) * count_ns());
}

void WatchdogPair::Window::act(std::int64_t now_ns) {
    if (now_ns >= bites_at_) {
        return pair_.reset("window: fed too late", now_ns, clock_fields::kWwdgReset);
    }
    warns_at_ = kNever;
    flag_ = true;
    if ((configuration_ & kEarly.mask()) != 0) {
        pair_.machine_.raise(kWarningInterrupt);
    }
}

}  // namespace sc::model
