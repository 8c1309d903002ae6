// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/optics.hpp"

namespace sc::model {
namespace {

constexpr std::uint32_t kEn = 1U << 0U;
constexpr std::uint32_t kCirc = 1U << 8U;
constexpr std::uint32_t kMinc = 1U << 10U;
constexpr std::uint32_t kDbm = 1U << 18U;
constexpr std::uint32_t kCt = 1U << 19U;
/// May be changed while the stream runs: the enable bit and the interrupts.
constexpr std::uint32_t kFreeBits = 0x1F;
constexpr std::uint32_t kTransferErrorFlag = 1U << 3U;
constexpr std::uint32_t kHalfFlag = 1U << 4U;
constexpr std::uint32_t kCompleteFlag = 1U << 5U;
constexpr std::array<unsigned, 4> kFlagPlace{0, 6, 16, 22};
constexpr unsigned kFirstStreamInterrupt = 11;
constexpr unsigned kFirstStreamInterrupt2 = 56;

bool to_peripheral(std::uint32_t control) { return ((control >> 6U) & 3U) == 1; }

/// AXI SRAM and SRAM1 to SRAM3.
bool reached(std::uint32_t at) {
    return (at >= 0x24000000 && at < 0x24080000) || (at >= 0x30000000 && at < 0x30048000);
}

}  // namespace

void ClockGates::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (bytes != 4 || (offset != kAhb1 && offset != kAhb2 && offset != kAhb4 && offset != kApb1l &&
                       offset != rcc::kApb1h && offset != kApb2 && offset != kApb4)) {
        machine_.violation("RCC: a register that the drivers do not need is written");
    }
    RegisterWords::write(offset, value, bytes);
}

bool ClockGates::check(std::uint32_t offset, unsigned bit, const char* who) const {
    if (!has(offset, 1U << bit)) {
        machine_.violation(std::string(who) + ": its clock is off");
        return false;
    }
    return true;
}

int EdgePort::function(unsigned pin) const {
    if (((mode_ >> (2 * pin)) & 3U) != 2) {
        return -1;
    }
    return static_cast<int>((function_.at(pin / 8) >> (4 * (pin % 8))) & 15U);
}

std::uint32_t EdgePort::read(std::uint32_t offset) {
    switch (offset) {
        case 0x00: return mode_;
        case 0x04: return type_;
        case 0x08: return speed_;
        case 0x0C: return pull_;
        case 0x20: return function_[0];
        case 0x24: return function_[1];
        case 0x10: {
            std::uint32_t inputs = 0;
            for (unsigned pin = 0; pin < 16; ++pin) {
                inputs |= ((mode_ >> (2 * pin)) & 3U) == 0 ? input_ & (1U << pin) : 0;
            }
            if (after_read) {
                after_read();
            }
            return inputs;
        }
        case 0x14: return level_;
        default: return 0;
    }
}

void EdgePort::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (!clocks_.check(ClockGates::kAhb4, 4, "GPIOE")) {
        return;
    }
    const std::uint32_t before = level_ & outputs();
    switch (offset) {
        case 0x00:
            mode_ = value;
            outputs_ = 0;
            for (unsigned pin = 0; pin < 16; ++pin) {
                outputs_ |= ((mode_ >> (2 * pin)) & 3U) == 1 ? 1U << pin : 0;
            }
            break;
        case 0x04: type_ = value; break;
        case 0x08: speed_ = value; break;
        case 0x0C: pull_ = value; break;
        case 0x20: function_[0] = value; break;
        case 0x24: function_[1] = value; break;
        case 0x18:
            if (bytes != 4) {
                machine_.violation("GPIOE: BSRR is a word");
            }
            level_ = (level_ & ~(value >> 16U)) | (value & 0xFFFFU);  // set wins
            break;
        default: machine_.violation("GPIOE: a register that is not modelled"); break;
    }
    const std::uint32_t after = level_ & outputs();
    if (after != before) {
        edges.push_back({machine_.now_ns(), before, after});
        if (on_edge) {
            on_edge(before, after);
        }
    }
}

void DmaModel::Mux::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    const unsigned n = offset / 4;
    if (bytes != 4 || offset % 4 != 0 || (value & ~0x7FU) != 0) {
        dma_.note("DMAMUX1: only a request is to be chosen");
    }
    if ((dma_.streams_.at(n).cr & kEn) != 0) {
        dma_.note("DMAMUX1: changed under a stream that runs");
    }
    (void)dma_.clocks_.check(ClockGates::kAhb1, dma_.clock_bit(), "DMAMUX1");
    dma_.request_.at(n) = value;
}

std::uint32_t DmaModel::read(std::uint32_t offset) {
    if (offset < 0x08) {
        std::uint32_t flags = 0;
        for (unsigned i = 0; i < 4; ++i) {
            flags |= streams_.at(offset + i).flags << kFlagPlace.at(i);
        }
        return flags;
    }
    if (offset < 0x10) {
        return 0;
    }
    const Stream& stream = streams_.at((offset - 0x10) / 0x18);
    switch ((offset - 0x10) % 0x18) {
        case 0x00: return stream.cr;
        case 0x04: return stream.left;
        case 0x08: return stream.par;
        case 0x0C: return stream.memory[0];
        case 0x10: return stream.memory[1];
        default: return stream.fcr;
    }
}

void DmaModel::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (bytes != 4) {
        note("registers are words");
    }
    if (!clocks_.check(ClockGates::kAhb1, clock_bit(), name())) {
        return;
    }
    if (offset == 0x08 || offset == 0x0C) {
        for (unsigned i = 0; i < 4; ++i) {
            streams_.at(offset - 0x08 + i).flags &= ~(value >> kFlagPlace.at(i));
        }
        return;
    }
    if (offset < 0x10) {
        note("flags are cleared by LIFCR and HIFCR");
        return;
    }
    const unsigned n = (offset - 0x10) / 0x18;
    Stream& stream = streams_.at(n);
    const bool runs = (stream.cr & kEn) != 0;
    const auto idle = [&](const char* what) {
        if (runs) {
            note(std::string(what) + " is written while the stream runs");
        }
        return !runs;
    };
    switch ((offset - 0x10) % 0x18) {
        case 0x00: control(n, value); break;
        case 0x04:
            if (idle("NDTR")) {
                stream.count = stream.left = value & 0xFFFFU;
            }
            break;
        case 0x08:
            if (idle("PAR")) {
                stream.par = value;
            }
            break;
        case 0x0C:
        case 0x10: {
            const unsigned which = (offset - 0x10) % 0x18 == 0x0C ? 0 : 1;
            const bool in_play = which == ((stream.cr & kCt) != 0 ? 1U : 0U);
            if (runs && ((stream.cr & kDbm) == 0 || in_play)) {
                note("the address in play is written");
                stream.flags |= kTransferErrorFlag;
                stream.cr &= ~kEn;
            }
            stream.memory.at(which) = value;
            break;
        }
        default:
            if (idle("FCR")) {
                stream.fcr = value;
            }
            break;
    }
}

void DmaModel::control(unsigned n, std::uint32_t value) {
    Stream& stream = streams_.at(n);
    if ((stream.cr & kEn) != 0) {
        if (((stream.cr ^ value) & ~kFreeBits) != 0) {
            note("settings are changed while the stream runs");
            value = (value & kFreeBits) | (stream.cr & ~kFreeBits);
        }
        stream.cr = value;
        return;
    }
    if ((value & kEn) != 0) {
        const std::array<std::uint32_t, 2> memory = stream.memory;
        if (stream.flags != 0) {
            note("enabled while flags of its last run stand");
        }
        if (stream.par == 0 || stream.count == 0 || !reached(memory[0]) ||
            ((value & kDbm) != 0 && !reached(memory[1]))) {
            note("enabled without addresses that it reaches, or without a count");
            return;
        }
        stream.left = stream.count;
        stream.at = 0;
        stream.cr = value;
        if (to_peripheral(value)) {
            read_ahead(stream);
        }
    }
    stream.cr = value;
}

void DmaModel::request(std::uint32_t line) {
    bool taken = false;
    for (unsigned n = 0; n < streams_.size(); ++n) {
        if (request_.at(n) == line && (streams_.at(n).cr & kEn) != 0) {
            transfer(n);
            taken = true;
        }
    }
    if (!taken) {
        note("DMAMUX1: request " + std::to_string(line) + " finds no stream");
    }
}

/// The word that the next request moves. In direct mode it is read as soon as the one before has gone.
void DmaModel::read_ahead(Stream& stream) {
    const std::uint32_t from = stream.memory.at((stream.cr & kCt) != 0 ? 1 : 0) + 4 * stream.at;
    if (from >= 0x30000000) {
        const bool second = from >= 0x30020000;
        (void)clocks_.check(ClockGates::kAhb2, second ? 30 : 29, second ? "SRAM2" : "SRAM1");
    }
    stream.ahead = machine_.bus_read(from, 4);
}

void DmaModel::transfer(unsigned n) {
    Stream& stream = streams_.at(n);
    const bool words = ((stream.cr >> 11U) & 3U) == 2 && ((stream.cr >> 13U) & 3U) == 2;
    if (!words || (stream.cr & kMinc) == 0 || (stream.cr & (1U << 9U)) != 0 || ((stream.cr >> 6U) & 3U) > 1) {
        note("this stream is to move words between memory and one register");
        return;
    }
    const bool out = to_peripheral(stream.cr);
    if (out) {
        machine_.bus_write(stream.par, stream.ahead, 4);
    } else {
        machine_.bus_write(stream.memory[0] + 4 * stream.at, machine_.bus_read(stream.par, 4), 4);
    }
    ++stream.at;
    --stream.left;
    if (stream.left == stream.count / 2) {
        stream.flags |= kHalfFlag;
    }
    if (stream.left == 0) {
        finish(n);
    }
    if (out && (stream.cr & kEn) != 0) {
        read_ahead(stream);
    }
}

void DmaModel::finish(unsigned n) {
    Stream& stream = streams_.at(n);
    stream.flags |= kCompleteFlag;
    if ((stream.cr & (kCirc | kDbm)) == 0) {
        stream.cr &= ~kEn;
    } else {
        stream.left = stream.count;
        stream.at = 0;
        stream.cr ^= (stream.cr & kDbm) != 0 ? kCt : 0;
    }
    if ((stream.cr & (1U << 4U)) != 0) {
        machine_.raise((which_ == Which::first ? kFirstStreamInterrupt : kFirstStreamInterrupt2) + n);
    }
}

std::uint32_t BasicTimer::read(std::uint32_t offset) {
    if (offset == 0x24) {
        machine_.violation("TIM6: the counter is not modelled");
    }
    return words_.at(offset / 4);
}

void BasicTimer::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (bytes != 4) {
        machine_.violation("TIM6: registers are written as words");
    }
    if (!clocks_.check(ClockGates::kApb1l, 4, "TIM6")) {
        return;
    }
    if (offset == 0x14) {
        update();
        return;
    }
    const bool ran = (words_[0x00 / 4] & 1U) != 0;
    if (ran && (offset == 0x28 || offset == 0x2C)) {
        machine_.violation("TIM6: its period is changed while it counts");
    }
    words_.at(offset / 4) = value;
    const bool runs = (words_[0x00 / 4] & 1U) != 0;
    if (runs && !ran) {
        started_ns = machine_.now_ns();
        ticks_ = std::int64_t{words_[0x2C / 4]} + 1;
        if (words_[0x2C / 4] == 0 || words_[0x28 / 4] != 0) {
            machine_.violation("TIM6: started without the period that is wanted");
            words_[0x00 / 4] = 0;
        }
    }
}

std::int64_t BasicTimer::next_ns() const {
    if ((words_[0x00 / 4] & 1U) == 0) {
        return kNever;
    }
    return started_ns + (ticks_ * 25 + 5) / 6;  // 240 MHz: 25/6 ns
}

void BasicTimer::act(std::int64_t /*now_ns*/) {
    ticks_ += std::int64_t{words_[0x2C / 4]} + 1;
    update();
}

void BasicTimer::update() {
    words_[0x10 / 4] |= 1U;
    if ((words_[0x0C / 4] & (1U << 8U)) != 0) {
        dma_.request(kRequest);
    }
}

}  // namespace sc::model
