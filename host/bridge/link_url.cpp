// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/link_url.hpp"

#include <charconv>
#include <limits>
#include <string_view>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr std::string_view kForms =
    "use sim:, sim:?carrier=can, can:can0, can:can0?fd=1, serial:/dev/ttyUSB0?baud=921600, tcp:127.0.0.1:7000 or "
    "lockstep:SOCKET";

[[noreturn]] void refuse(const std::string& problem, std::string_view value) {
    throw InputError({.file = {}, .problem = problem, .value = std::string(value), .action = std::string(kForms)});
}

/// A positive whole number up to `limit`, all of the text.
unsigned number(std::string_view text, unsigned limit, const std::string& problem) {
    unsigned value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value == 0 || value > limit) {
        refuse(problem, text);
    }
    return value;
}

/// Of a simulated cell, from what stands behind the question mark.
SimCarrier carrier_of(std::string_view query) {
    constexpr std::string_view kCarrier = "carrier=";
    if (!query.starts_with(kCarrier)) {
        refuse("unknown option of a simulated cell's link", query);
    }
    const std::string_view name = query.substr(kCarrier.size());
    if (name == "serial") {
        return SimCarrier::serial;
    }
    if (name == "can") {
        return SimCarrier::can;
    }
    if (name == "canfd") {
        return SimCarrier::canfd;
    }
    throw InputError({.file = {},
                      .problem = "unknown carrier of a simulated cell",
                      .value = std::string(name),
                      .action = "use carrier=serial, carrier=can or carrier=canfd"});
}

SerialUrl serial_url(std::string_view rest) {
    constexpr std::string_view kBaud = "baud=";
    const std::size_t mark = rest.find('?');
    SerialUrl url{std::string(rest.substr(0, mark)), 0};
    if (url.device.empty()) {
        refuse("link names no serial device", rest);
    }
    if (mark != std::string_view::npos) {
        const std::string_view query = rest.substr(mark + 1);
        if (!query.starts_with(kBaud)) {
            refuse("unknown option of a serial link", query);
        }
        url.baud =
            number(query.substr(kBaud.size()), std::numeric_limits<unsigned>::max(), "no speed of a serial line");
    }
    return url;
}

TcpUrl tcp_url(std::string_view rest) {
    const std::size_t colon = rest.rfind(':');
    if (colon == std::string_view::npos || colon == 0) {
        refuse("link names no TCP host and port", rest);
    }
    const unsigned port = number(rest.substr(colon + 1), 65535, "no TCP port");
    return {std::string(rest.substr(0, colon)), static_cast<std::uint16_t>(port)};
}

CanUrl can_url(std::string_view rest) {
    const std::size_t mark = rest.find('?');
    const CanUrl url{std::string(rest.substr(0, mark)), rest.ends_with("?fd=1")};
    if (url.interface.empty()) {
        refuse("link names no CAN interface", rest);
    }
    if (mark != std::string_view::npos && rest.substr(mark) != "?fd=1" && rest.substr(mark) != "?fd=0") {
        refuse("unknown option of a CAN link (there is fd=1)", rest.substr(mark + 1));
    }
    return url;
}

}  // namespace

LinkUrl parse_link_url(const std::string& url) {
    const std::string_view text = url;
    const std::size_t colon = text.find(':');
    const std::string_view scheme = text.substr(0, colon);
    const std::string_view rest = colon == std::string_view::npos ? std::string_view{} : text.substr(colon + 1);
    if (scheme == "can") {
        return can_url(rest);
    }
    if (scheme == "sim" && (rest.empty() || rest.front() == '?')) {
        return SimulatedUrl{rest.empty() ? SimCarrier::serial : carrier_of(rest.substr(1))};
    }
    if (const std::size_t mark = rest.find('?'); scheme == "lockstep" && !rest.empty() && mark != 0) {
        const bool told = mark != std::string_view::npos;
        return LockStepUrl{std::string(rest.substr(0, mark)),
                           told ? carrier_of(rest.substr(mark + 1)) : SimCarrier::serial};
    }
    if (scheme == "serial" && colon != std::string_view::npos) {
        return serial_url(rest);
    }
    if (scheme == "tcp" && colon != std::string_view::npos) {
        return tcp_url(rest);
    }
    refuse("unknown link", url);
}

}  // namespace sc::host
