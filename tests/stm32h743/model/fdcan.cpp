// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/fdcan.hpp"

#include <algorithm>
#include <set>

namespace sc::model {
namespace {

using namespace fdcan_at;

constexpr std::uint32_t kInit = 1, kCce = 2, kCsa = 8, kCsr = 16, kModes = 0x300;
constexpr std::uint32_t kKnownControl = kInit | kCce | kCsa | kCsr | kModes;
constexpr std::uint32_t kIrNew = 1, kIrLost = 8, kIrBusOff = 1U << 25U;
constexpr std::uint32_t kReleased = 0xDEADDEAD;
constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kCrossingNs = 250;  // of CCCR between the clocks
constexpr std::uint32_t kPassiveAt = 128, kWarningAt = 96, kOffAt = 256;
const std::array<std::uint32_t, 8> kDataBytes{8, 12, 16, 20, 24, 32, 48, 64};
const std::array<std::uint8_t, 16> kLengths{0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};

std::uint32_t bits(std::uint32_t word, unsigned first, unsigned width) { return word >> first & ((1U << width) - 1U); }

}  // namespace

FdcanRam::FdcanRam(Machine& machine, const RegisterWords& clocks) : machine_(machine), clocks_(clocks) {
    words_.fill(0x5A5AA5A5);  // not cleared by a reset
    machine.attach(kBase, kBytes, *this);
}

std::uint32_t FdcanRam::read(std::uint32_t offset) {
    for (const FdcanModel* user : users_) {
        const FdcanModel::Part part = user->receive_part();
        if (user->running() && part.holds(offset) && !user->has_frame((offset - part.begin) / part.element)) {
            machine_.violation("FDCAN: read of an element that holds no frame");
        }
    }
    return clocks_.has(rcc::kApb1h, rcc::kFdcan) ? word(offset) : 0;
}

void FdcanRam::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (bytes != 4) {
        machine_.violation("FDCAN: message RAM is written by less than a word");
    }
    if (!clocks_.has(rcc::kApb1h, rcc::kFdcan)) {
        machine_.violation("FDCAN: message RAM is written without a clock");
        return;
    }
    for (const FdcanModel* user : users_) {
        const FdcanModel::Part part = user->send_part();
        if (user->running() && part.holds(offset) && user->waits_to_send((offset - part.begin) / part.element)) {
            machine_.violation("FDCAN: write to an element that waits to be sent");
        }
        if (user->running() && user->receive_part().holds(offset)) {
            machine_.violation("FDCAN: write into the receive FIFO");
        }
    }
    set_word(offset, value);
}

FdcanModel::FdcanModel(Machine& machine, const RegisterWords& clocks, FdcanRam& ram, CanWire& wire, std::uint32_t base,
                       std::int64_t kernel_hz)
    : machine_(machine), clocks_(clocks), ram_(ram), wire_(wire), base_(base), kernel_hz_(kernel_hz) {
    machine.attach(base, kSize, *this);
    ram.add(*this);
    wire.join(*this);
    word(endn) = 0x87654321;
    word(dbtp) = 0x00000A33;
    word(nbtp) = 0x06000A03;
    last_error_ = 7;
}

void FdcanModel::note(const std::string& what) {
    machine_.violation("FDCAN" + std::to_string(base_ == kFdcan1 ? 1 : 2) + ": " + what);
}

FdcanModel::Part FdcanModel::receive_part() const {
    return {peek(rxf0c) & 0xFFFCU, 8 + kDataBytes.at(peek(rxesc) & 7U), bits(peek(rxf0c), 16, 7)};
}

FdcanModel::Part FdcanModel::send_part() const {
    return {peek(txbc) & 0xFFFCU, 8 + kDataBytes.at(peek(txesc) & 7U), bits(peek(txbc), 24, 6)};
}

bool FdcanModel::has_frame(std::uint32_t index) const {
    const std::uint32_t count = receive_part().count;
    return count != 0 && (index + count - rx_get_) % count < rx_fill_;
}

std::int64_t FdcanModel::bit_ns() const {
    const std::uint32_t t = peek(nbtp);
    const std::int64_t quanta = 3 + std::int64_t{bits(t, 8, 8)} + std::int64_t{bits(t, 0, 7)};
    return (1 + std::int64_t{bits(t, 16, 9)}) * quanta * kSecond / kernel_hz_;
}

WireRates FdcanModel::rates() const {
    const std::uint32_t t = peek(dbtp);
    const std::int64_t quanta = 3 + std::int64_t{bits(t, 8, 5)} + std::int64_t{bits(t, 4, 4)};
    const std::int64_t data = kernel_hz_ / ((1 + std::int64_t{bits(t, 16, 5)}) * quanta);
    return {kSecond / bit_ns(), (peek(cccr) & 0x100U) != 0 ? data : 0};
}

/// The sample point, or with compensation the second one, counted from where the bit arrives, must lie within it.
bool FdcanModel::hears_own_fast_bits() const {
    const std::uint32_t t = peek(dbtp);
    const std::int64_t quantum_hz = kernel_hz_ / (1 + std::int64_t{bits(t, 16, 5)});
    const std::int64_t bit = kSecond / rates().data;
    if ((t >> 23U & 1U) != 0) {
        const std::int64_t second = std::int64_t{bits(peek(tdcr), 8, 7)} * kSecond / kernel_hz_;
        return second > bit / 4 && second < bit;
    }
    return (2 + std::int64_t{bits(t, 8, 5)}) * kSecond / quantum_hz > loop_delay_ns_;
}

std::uint32_t FdcanModel::stamp(std::int64_t ns) const {
    if ((peek(tscc) & 3U) != 1) {
        return 0;
    }
    return static_cast<std::uint32_t>((ns - stamp_from_ns_) /
                                      (bit_ns() * (1 + std::int64_t{bits(peek(tscc), 16, 4)}))) &
           0xFFFFU;
}

/// What has come about since the last look.
void FdcanModel::settle() {
    const std::int64_t now = machine_.now_ns();
    if (kernel_hz_ != 0 && init_ != init_asked_ && now >= init_at_ns_) {
        set_init(init_asked_);
    }
    if (bus_off_ && !init_ && now >= ready_ns_) {
        bus_off_ = false;
        tx_errors_ = rx_errors_ = 0;
        flag(kIrBusOff);
    }
}

void FdcanModel::set_init(bool on) {
    init_ = init_asked_ = on;
    if (on) {
        return;
    }
    change_enable_ = false;
    check_settings();
    const std::int64_t bits_of_silence = bus_off_ ? 129 * 11 : 11;
    ready_ns_ = std::max(machine_.now_ns(), wire_.busy_until_ns()) + bits_of_silence * bit_ns();
    stamp_from_ns_ = machine_.now_ns();
}

void FdcanModel::check_timing() {
    const std::uint32_t slow = peek(nbtp);
    const std::uint32_t fast = peek(dbtp);
    if (bits(slow, 8, 8) < 1 || bits(slow, 0, 7) < 1 || bits(slow, 25, 7) > bits(slow, 0, 7)) {
        note("nominal bit timing is not allowed");
    }
    if ((peek(cccr) & 0x100U) != 0 && bits(fast, 0, 4) > bits(fast, 4, 4)) {
        note("data bit timing is not allowed");
    }
    if ((fast >> 23U & 1U) != 0 && bits(fast, 16, 5) > 1) {
        note("delay compensation with a prescaler above 2");
    }
    if ((peek(tscc) & 3U) == 1 && (peek(cccr) & 0x200U) != 0) {
        note("time stamps by bits of two rates");
    }
}

void FdcanModel::check_settings() {
    check_timing();
    if (receive_part().count > 64 || send_part().count > 32) {
        note("more elements than there can be");
    }
    if (bits(peek(txbc), 16, 6) != 0 || bits(peek(sidfc), 16, 8) != 0 || bits(peek(xidfc), 16, 7) != 0) {
        note("dedicated buffers and filter lists are not modelled");
    }
    std::vector<Part> parts;
    for (const FdcanModel* user : ram_.users()) {
        if (user->running()) {
            parts.push_back(user->receive_part());
            parts.push_back(user->send_part());
        }
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (parts[i].end() > FdcanRam::kBytes) {
            note("elements beyond the message RAM");
        }
        for (std::size_t j = 0; j < i; ++j) {
            if (parts[i].begin < parts[j].end() && parts[j].begin < parts[i].end()) {
                note("parts of the message RAM overlap");
            }
        }
    }
}

std::uint32_t FdcanModel::read(std::uint32_t offset) {
    if (!clocks_.has(rcc::kApb1h, rcc::kFdcan)) {
        return 0;
    }
    settle();
    const std::uint32_t count = std::max(1U, receive_part().count);
    const std::uint32_t sends = std::max(1U, send_part().count);
    switch (offset) {
        case cccr: return (peek(cccr) & ~(kInit | kCce)) | (init_ ? kInit : 0U) | (change_enable_ ? kCce : 0U);
        case tscv: return stamp(machine_.now_ns());
        case ecr: {
            const std::uint32_t value = std::min(tx_errors_, 255U) | std::min(rx_errors_, 127U) << 8U |
                                        (rx_errors_ >= kPassiveAt ? 1U << 15U : 0U) | logged_ << 16U;
            logged_ = 0;
            return value;
        }
        case psr: {
            const std::uint32_t worst = std::max(tx_errors_, rx_errors_);
            const std::uint32_t value = last_error_ | 7U << 8U | (worst >= kPassiveAt ? 1U << 5U : 0U) |
                                        (worst >= kWarningAt ? 1U << 6U : 0U) | (bus_off_ ? 1U << 7U : 0U);
            last_error_ = 7;
            return value;
        }
        case rxf0s:
            return rx_fill_ | rx_get_ << 8U | ((rx_get_ + rx_fill_) % count) << 16U |
                   (rx_fill_ == receive_part().count ? 1U << 24U : 0U) | (rx_lost_ ? 1U << 25U : 0U);
        case txfqs:
            return (send_part().count - tx_fill_) | tx_get_ << 8U | ((tx_get_ + tx_fill_) % sends) << 16U |
                   (tx_fill_ == send_part().count ? 1U << 21U : 0U);
        case txbrp: return pending_;
        case txbar: return 0;
        default: return words_.at(offset / 4);
    }
}

void FdcanModel::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    static const std::set<std::uint32_t> kProtected{dbtp,  nbtp,  tscc,  tdcr, gfc,  sidfc,
                                                    xidfc, rxf0c, rxesc, txbc, txesc};
    if (!clocks_.has(rcc::kApb1h, rcc::kFdcan) || bytes != 4) {
        note("written without a clock, or by less than a word");
        return;
    }
    settle();
    if (kProtected.contains(offset)) {
        if (!init_ || !change_enable_) {
            note("a protected register is written while the configuration is not open");
            return;
        }
        word(offset) = value;
        return;
    }
    switch (offset) {
        case cccr: write_control(value); break;
        case ir: {
            word(ir) &= ~value;
            rx_lost_ = rx_lost_ && (value & kIrLost) == 0;
            break;
        }
        case ie:
        case ils:
        case ile: word(offset) = value; break;
        case tscv: stamp_from_ns_ = machine_.now_ns(); break;
        case rxf0a: take_back(value); break;
        case txbar: add_requests(value); break;
        default: note("write to a register that takes none, at " + std::to_string(offset)); break;
    }
}

void FdcanModel::write_control(std::uint32_t value) {
    if ((value & ~kKnownControl) != 0) {
        note("reserved or unmodelled bits of CCCR");
    }
    const bool may_change = init_ && change_enable_;
    if ((value & kModes) != (peek(cccr) & kModes)) {
        if (may_change) {
            word(cccr) = (peek(cccr) & ~kModes) | (value & kModes);
        } else {
            note("a protected bit of CCCR is written while the configuration is not open");
        }
    }
    if ((value & kCsr) != 0) {
        note("clock stop is not modelled");
    }
    if ((value & kCce) != 0 && !change_enable_) {
        if (!init_) {
            note("CCE is set before INIT reads 1");
        } else {
            change_enable_ = true;
            rx_get_ = rx_fill_ = tx_get_ = tx_fill_ = pending_ = 0;
            rx_lost_ = false;
        }
    } else if ((value & kCce) == 0) {
        change_enable_ = false;
    }
    const bool asked = (value & kInit) != 0;
    if (asked != init_asked_) {
        init_asked_ = asked;
        init_at_ns_ = machine_.now_ns() + kCrossingNs;
    }
}

void FdcanModel::add_requests(std::uint32_t requests) {
    if (change_enable_) {
        note("a frame is to be sent while the configuration is open");
        return;
    }
    const std::uint32_t count = send_part().count;
    const std::uint32_t put = count == 0 ? 0 : (tx_get_ + tx_fill_) % count;
    if (count == 0 || tx_fill_ == count || requests != 1U << put) {
        note("a frame is to be sent that is not at the put index, or the FIFO is full");
        return;
    }
    pending_ |= requests;
    ++tx_fill_;
    const std::uint32_t second = ram_.word(send_part().begin + put * send_part().element + 4);
    const bool fd = (second >> 21U & 1U) != 0;
    const bool fast = (second >> 20U & 1U) != 0;
    if ((fd && (peek(cccr) & 0x100U) == 0) || (fast && (peek(cccr) & 0x200U) == 0) || (fast && !fd)) {
        note("a frame of a format that is not enabled");
    }
    if (fd && kLengths.at(second >> 16U & 15U) > send_part().element - 8) {
        note("a frame longer than its element");
    }
}

void FdcanModel::take_back(std::uint32_t index) {
    if (rx_fill_ == 0 || index != rx_get_) {
        note("acknowledged what is not the oldest frame");
        return;
    }
    const Part part = receive_part();
    for (std::uint32_t byte = 0; byte < part.element; byte += 4) {
        ram_.set_word(part.begin + index * part.element + byte, kReleased);
    }
    rx_get_ = (rx_get_ + 1) % part.count;
    --rx_fill_;
}

void FdcanModel::flag(std::uint32_t bit) {
    word(ir) |= bit;
    if ((peek(ie) & bit) != 0 && (peek(ils) & bit) == 0 && (peek(ile) & 1U) != 0) {
        machine_.raise(base_ == kFdcan1 ? kFdcan1Line0 : kFdcan2Line0);
    }
}

std::int64_t FdcanModel::next_ns() const {
    if (init_ != init_asked_) {
        return kernel_hz_ == 0 ? kNever : init_at_ns_;
    }
    return bus_off_ && !init_ ? ready_ns_ : kNever;
}

std::int64_t FdcanModel::ready_ns() const { return init_ ? kNever : ready_ns_; }

std::optional<WireFrame> FdcanModel::wants() const {
    if (pending_ == 0 || init_) {
        return std::nullopt;
    }
    const Part part = send_part();
    const std::uint32_t at = part.begin + tx_get_ * part.element;
    const std::uint32_t first = ram_.word(at);
    const std::uint32_t second = ram_.word(at + 4);
    WireFrame frame;
    frame.extended = (first >> 30U & 1U) != 0;
    frame.remote = (first >> 29U & 1U) != 0;
    frame.id = frame.extended ? first & 0x1FFFFFFFU : first >> 18U & 0x7FFU;
    frame.fd = (second >> 21U & 1U) != 0;
    frame.fast = (second >> 20U & 1U) != 0;
    const std::uint8_t length = kLengths.at(second >> 16U & 15U);
    const std::uint8_t size = frame.fd ? length : std::min<std::uint8_t>(length, 8);
    frame.asked = frame.remote ? size : std::uint8_t{0};
    for (std::uint32_t i = 0; i < size && !frame.remote; ++i) {
        frame.data.push_back(static_cast<std::uint8_t>(ram_.word(at + 8 + i / 4 * 4) >> (8 * (i % 4))));
    }
    return frame;
}

void FdcanModel::sent() {
    settle();
    pending_ &= ~(1U << tx_get_);
    tx_get_ = (tx_get_ + 1) % send_part().count;
    --tx_fill_;
    tx_errors_ -= tx_errors_ > 0 ? 1 : 0;
    last_error_ = 0;
}

void FdcanModel::heard(const WireFrame& frame, std::int64_t began_ns) {
    settle();
    rx_errors_ -= rx_errors_ > 0 ? 1 : 0;
    last_error_ = 0;
    const std::uint32_t rules = peek(gfc);
    const bool rejected = frame.remote && (rules >> (frame.extended ? 0U : 1U) & 1U) != 0;
    const std::uint32_t where = bits(rules, frame.extended ? 2 : 4, 2);
    if (rejected || where != 0) {
        return;  // FIFO 1 has no elements
    }
    if (rx_fill_ == receive_part().count) {
        if (peek(rxf0c) >> 31U != 0) {
            note("overwriting mode is not modelled");
        }
        rx_lost_ = true;
        flag(kIrLost);
        return;
    }
    store(frame, began_ns);
}

void FdcanModel::store(const WireFrame& frame, std::int64_t began_ns) {
    const Part part = receive_part();
    const std::uint32_t at = part.begin + (rx_get_ + rx_fill_) % part.count * part.element;
    const std::size_t size = frame.remote ? frame.asked : frame.data.size();
    const auto code = static_cast<std::uint32_t>(std::ranges::find(kLengths, size) - kLengths.begin());
    ram_.set_word(at, (frame.extended ? 1U << 30U | frame.id : frame.id << 18U) | (frame.remote ? 1U << 29U : 0U));
    ram_.set_word(at + 4, 1U << 31U | (frame.fd ? 1U << 21U : 0U) | (frame.fast ? 1U << 20U : 0U) | code << 16U |
                              stamp(began_ns));
    for (std::size_t i = 0; i < frame.data.size() && i < part.element - 8; ++i) {
        const std::uint32_t byte = at + 8 + static_cast<std::uint32_t>(i / 4 * 4);
        const auto shift = static_cast<std::uint32_t>(8 * (i % 4));
        ram_.set_word(byte, (ram_.word(byte) & ~(0xFFU << shift)) | std::uint32_t{frame.data[i]} << shift);
    }
    ++rx_fill_;
    flag(kIrNew);
}

void FdcanModel::failed(bool sender, WireError error) {
    settle();
    last_error_ = static_cast<std::uint32_t>(error);
    logged_ = std::min(logged_ + 1, 255U);
    if (!sender) {
        rx_errors_ = std::min(rx_errors_ + 1, 135U);
        return;
    }
    if (error == WireError::ack && tx_errors_ >= kPassiveAt) {
        return;  // alone on the bus is not its own fault
    }
    tx_errors_ += 8;
    if (tx_errors_ >= kOffAt) {
        bus_off_ = true;
        init_ = init_asked_ = true;
        flag(kIrBusOff);
    }
}

}  // namespace sc::model
