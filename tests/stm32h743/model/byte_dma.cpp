// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/byte_dma.hpp"

#include <algorithm>

namespace sc::model {
namespace {

constexpr std::uint32_t kLisr = 0x00, kHisr = 0x04, kLifcr = 0x08, kHifcr = 0x0C, kFirst = 0x10, kStep = 0x18;
constexpr std::uint32_t kCr = 0x00, kNdtr = 0x04, kPar = 0x08, kM0ar = 0x0C;
constexpr std::uint32_t kEn = 1U << 0U, kOut = 1U << 6U, kCirc = 1U << 8U, kMinc = 1U << 10U, kTrbuff = 1U << 20U;
constexpr std::uint32_t kSizes = 0xFU << 11U, kDbm = 1U << 18U;
constexpr std::uint32_t kError = 1U << 3U, kHalf = 1U << 4U, kDone = 1U << 5U;
constexpr std::uint32_t kFirstUsart = 41, kLastUsart = 46;
constexpr std::int64_t kStopNs = 100;
constexpr std::array<unsigned, 4> kFlagsAt{0, 6, 16, 22};

}  // namespace

ByteDma::ByteDma(Machine& machine, const RegisterWords& clocks) : machine_(machine), clocks_(clocks) {
    machine.attach(kBase, kSize, *this);
    machine.attach(kMuxBase, kMuxSize, mux_);
}

void ByteDma::note(unsigned stream, const std::string& what) {
    machine_.violation("DMA1 stream " + std::to_string(stream) + ": " + what);
}

std::uint32_t ByteDma::read(std::uint32_t offset) {
    if (!clocks_.has(rcc::kAhb1, rcc::kDma1)) {
        return 0;
    }
    if (offset == kLisr || offset == kHisr) {
        std::uint32_t value = 0;
        for (unsigned i = 0; i < 4; ++i) {
            value |= streams_.at(i + (offset == kHisr ? 4 : 0)).flags << kFlagsAt.at(i);
        }
        return value;
    }
    if (offset < kFirst) {
        return 0;
    }
    const Stream& s = streams_.at((offset - kFirst) / kStep);
    switch ((offset - kFirst) % kStep) {
        case kCr: return s.settings | (s.enabled ? kEn : 0U);
        case kNdtr: return s.count;
        case kPar: return s.peripheral;
        case kM0ar: return s.memory;
        default: return 0;
    }
}

void ByteDma::write(std::uint32_t offset, std::uint32_t value, unsigned /*bytes*/) {
    if (!clocks_.has(rcc::kAhb1, rcc::kDma1)) {
        machine_.violation("DMA1: written without a clock");
        return;
    }
    if (offset == kLifcr || offset == kHifcr) {
        for (unsigned i = 0; i < 4; ++i) {
            streams_.at(i + (offset == kHifcr ? 4 : 0)).flags &= ~(value >> kFlagsAt.at(i) & 0x3DU);
        }
        return;
    }
    if (offset < kFirst) {
        machine_.violation("DMA1: flags are written");
        return;
    }
    const unsigned n = (offset - kFirst) / kStep;
    Stream& s = streams_.at(n);
    const std::uint32_t which = (offset - kFirst) % kStep;
    if (which == kCr) {
        write_settings(n, value);
        return;
    }
    if (s.enabled) {
        note(n, "a register is written while it runs");
        return;
    }
    switch (which) {
        case kNdtr: s.count = value & 0xFFFFU; break;
        case kPar: s.peripheral = value; break;
        case kM0ar: s.memory = value; break;
        default: note(n, "this register is not modelled"); break;
    }
}

void ByteDma::write_settings(unsigned n, std::uint32_t value) {
    Stream& s = streams_.at(n);
    if (s.enabled) {
        if ((value & kEn) == 0 && s.stops_ns == kNever) {
            s.stops_ns = machine_.now_ns() + kStopNs;
        } else if ((value & ~kEn) != s.settings) {
            note(n, "settings are written while it runs");
        }
        return;
    }
    s.settings = value & ~kEn;
    if ((value & kEn) != 0) {
        start(n);
    }
}

void ByteDma::start(unsigned n) {
    Stream& s = streams_.at(n);
    const std::uint32_t request = mux_.read(4 * n) & 0x7FU;
    if (s.flags != 0) {
        note(n, "started with flags of before");
        return;
    }
    if (s.count == 0 || (s.settings & (kSizes | kDbm)) != 0 || (s.settings & kMinc) == 0) {
        note(n, "started without a count, or not for bytes of a buffer");
        return;
    }
    if (s.memory < 0x24000000 || s.memory >= 0x40000000) {
        note(n, "memory that DMA1 does not reach");
        return;
    }
    if (request >= kFirstUsart && request <= kLastUsart && (s.settings & kTrbuff) == 0) {
        note(n, "serves a USART without bufferable transfers: may lock");
    }
    s.enabled = true;
    s.stops_ns = kNever;
    s.loaded = s.count;
    if (const auto again = ready_.find(request); again != ready_.end()) {
        again->second();
    }
}

bool ByteDma::serve(std::uint32_t request) {
    for (unsigned n = 0; n < streams_.size() && !held_; ++n) {
        Stream& s = streams_.at(n);
        if (!s.enabled || s.stops_ns != kNever || (mux_.read(4 * n) & 0x7FU) != request) {
            continue;
        }
        if (s.fails) {
            s.fails = s.enabled = false;
            s.flags |= kError;
            return false;
        }
        const std::uint32_t at = s.memory + (s.loaded - s.count);
        --s.count;
        if (s.count == s.loaded / 2) {
            s.flags |= kHalf;
        }
        if (s.count == 0) {
            s.flags |= kDone;
            s.enabled = (s.settings & kCirc) != 0;
            s.count = s.enabled ? s.loaded : 0;
        }
        if ((s.settings & kOut) != 0) {
            machine_.bus_write(s.peripheral, machine_.bus_read(at, 1), 4);
        } else {
            machine_.bus_write(at, machine_.bus_read(s.peripheral, 4) & 0xFFU, 1);
        }
        return true;
    }
    return false;
}

void ByteDma::hold(bool on) {
    held_ = on;
    for (const auto& [request, again] : ready_) {
        if (!on) {
            again();
        }
    }
}

std::int64_t ByteDma::next_ns() const {
    std::int64_t when = kNever;
    for (const Stream& s : streams_) {
        when = std::min(when, s.stops_ns);
    }
    return when;
}

void ByteDma::act(std::int64_t now_ns) {
    for (Stream& s : streams_) {
        if (s.stops_ns <= now_ns) {
            s.stops_ns = kNever;
            s.enabled = false;
            s.flags |= kDone;  // as the chip does for a stream that is stopped
        }
    }
}

}  // namespace sc::model
