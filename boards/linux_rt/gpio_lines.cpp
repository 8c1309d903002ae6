// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/gpio_lines.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include <gpiod.h>
#include <poll.h>

namespace sc::linux_rt {
namespace {

constexpr const char* kConsumer = "scribecell-rt";
constexpr int kMostEvents = 16;

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
    throw std::invalid_argument("--gpio " + text + ": " + why);
}

template <std::size_t N>
std::size_t place_of(const std::array<std::string_view, N>& names, std::string_view name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

LineWire wire_of(const std::string& text, std::string_view word) {
    LineWire wire;
    wire.active_low = word.starts_with('!');
    if (wire.active_low) {
        word.remove_prefix(1);
    }
    const std::size_t equals = word.find('=');
    if (equals == std::string_view::npos) {
        refuse(text, "'" + std::string(word) + "' is no NAME=OFFSET");
    }
    wire.name = word.substr(0, equals);
    const std::string_view digits = word.substr(equals + 1);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), wire.offset);
    if (error != std::errc{} || end != digits.data() + digits.size()) {
        refuse(text, "'" + std::string(digits) + "' is no offset of a line");
    }
    if (place_of(kInputNames, wire.name) == kInputs && place_of(kOutputNames, wire.name) == kOutputs) {
        refuse(text, "there is no line '" + wire.name + "' (--help lists them)");
    }
    return wire;
}

void check_one(const std::string& text, const LineWiring& wiring, const LineWire& wire) {
    for (const LineWire& other : wiring.wires) {
        if (other.name == wire.name) {
            refuse(text, "'" + wire.name + "' comes twice");
        }
        if (other.offset == wire.offset) {
            refuse(text, "offset " + std::to_string(wire.offset) + " is '" + other.name + "' already");
        }
    }
}

}  // namespace

LineWiring parse_wiring(const std::string& text) {
    LineWiring wiring;
    const std::size_t colon = text.find(':');
    wiring.chip = text.substr(0, colon);
    if (colon == std::string::npos || wiring.chip.empty()) {
        refuse(text, "use CHIP:NAME=OFFSET,…");
    }
    std::string_view rest = std::string_view(text).substr(colon + 1);
    while (!rest.empty()) {
        const std::size_t comma = rest.find(',');
        LineWire wire = wire_of(text, rest.substr(0, comma));
        check_one(text, wiring, wire);
        wiring.wires.push_back(std::move(wire));
        rest = comma == std::string_view::npos ? std::string_view{} : rest.substr(comma + 1);
    }
    for (const char* needed : {"estop", "interlock"}) {
        if (std::none_of(wiring.wires.begin(), wiring.wires.end(),
                         [needed](const LineWire& wire) { return wire.name == needed; })) {
            refuse(text, std::string("no line '") + needed + "': a cell without it cannot be stopped");
        }
    }
    return wiring;
}

GpioLines::GpioLines(const LineWiring& wiring) : chip_(::gpiod_chip_open_lookup(wiring.chip.c_str())) {
    if (chip_ == nullptr) {
        throw std::system_error(errno, std::generic_category(),
                                "GPIO chip " + wiring.chip + " (`scribecell ports` lists them; group gpio)");
    }
    try {
        for (const LineWire& wire : wiring.wires) {
            request(wire);
        }
    } catch (...) {
        ::gpiod_chip_close(chip_);
        throw;
    }
}

GpioLines::~GpioLines() {
    write(0);
    ::gpiod_chip_close(chip_);
}

void GpioLines::request(const LineWire& wire) {
    gpiod_line* line = ::gpiod_chip_get_line(chip_, wire.offset);
    const std::string what = "GPIO line " + std::to_string(wire.offset) + " (" + wire.name + ")";
    if (line == nullptr) {
        throw std::system_error(errno, std::generic_category(), what);
    }
    const std::size_t input = place_of(kInputNames, wire.name);
    int failed = 0;
    if (input < kInputs) {
        const int flags = wire.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
        failed = ::gpiod_line_request_both_edges_events_flags(line, kConsumer, flags);
        inputs_.at(input) = line;
        wired_ = static_cast<InputBits>(wired_ | 1U << input);
    } else {
        const int flags = wire.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
        failed = ::gpiod_line_request_output_flags(line, kConsumer, flags, 0);
        outputs_.at(place_of(kOutputNames, wire.name)) = line;
    }
    if (failed != 0) {
        throw std::system_error(errno, std::generic_category(), what + ": is it in use?");
    }
}

InputBits GpioLines::levels() noexcept {
    unsigned bits = 0;
    for (std::size_t i = 0; i < kInputs; ++i) {
        if (inputs_[i] != nullptr && ::gpiod_line_get_value(inputs_[i]) == 1) {
            bits |= 1U << i;
        }
    }
    return static_cast<InputBits>(bits);
}

void GpioLines::edges(InputBits& fell, InputBits& rose) noexcept {
    fell = rose = 0;
    for (std::size_t i = 0; i < kInputs; ++i) {
        if (inputs_[i] == nullptr) {
            continue;
        }
        pollfd wait{::gpiod_line_event_get_fd(inputs_[i]), POLLIN, 0};
        if (::poll(&wait, 1, 0) <= 0 || (wait.revents & POLLIN) == 0) {
            continue;
        }
        std::array<gpiod_line_event, kMostEvents> events{};
        const int n = ::gpiod_line_event_read_multiple(inputs_[i], events.data(), kMostEvents);
        for (int k = 0; k < n; ++k) {
            InputBits& bits =
                events.at(static_cast<std::size_t>(k)).event_type == GPIOD_LINE_EVENT_FALLING_EDGE ? fell : rose;
            bits = static_cast<InputBits>(bits | 1U << i);
        }
    }
}

void GpioLines::write(OutputBits bits) noexcept {
    if (last_ == bits) {
        return;
    }
    last_ = bits;
    for (std::size_t i = 0; i < kOutputs; ++i) {
        // The gate has its own ways, but for the last.
        if (outputs_[i] != nullptr && (i != static_cast<std::size_t>(Output::gate) || bits == 0)) {
            (void)::gpiod_line_set_value(outputs_[i], static_cast<int>(bits >> i & 1U));
        }
    }
}

void GpioLines::set_gate(bool open) noexcept {
    if (gpiod_line* line = outputs_[static_cast<std::size_t>(Output::gate)]; line != nullptr) {
        (void)::gpiod_line_set_value(line, open ? 1 : 0);
    }
}

}  // namespace sc::linux_rt
