// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/host_link.hpp"

#include <algorithm>
#include <charconv>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace sc::linux_rt {
namespace {

[[noreturn]] void refuse(const std::string& text) {
    throw std::invalid_argument("--link " + text +
                                ": use can:can0, can:can0?fd=1, serial:/dev/ttyS0?baud=921600, tcp:7000 or "
                                "tcp:0.0.0.0:7000");
}

unsigned number(const std::string& text, std::string_view digits, unsigned most) {
    unsigned value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || value > most) {
        refuse(text);
    }
    return value;
}

std::unique_ptr<HostLink> open_can(const std::string& text, std::string_view rest) {
    const std::size_t mark = rest.find('?');
    const std::string interface(rest.substr(0, mark));
    const std::string_view query = mark == std::string_view::npos ? std::string_view{} : rest.substr(mark + 1);
    if (interface.empty() || (mark != std::string_view::npos && query != "fd=1" && query != "fd=0")) {
        refuse(text);
    }
    socketcan::CanOptions options;
    options.fd = query == "fd=1";
    options.filters = {{link::kCanIdToController, 0x7FF}};
    return std::make_unique<CanLink>(socketcan::CanSocket(interface, options), options.fd, text);
}

std::unique_ptr<HostLink> open_serial(const std::string& text, std::string_view rest) {
    constexpr std::string_view kBaud = "baud=";
    const std::size_t mark = rest.find('?');
    unsigned baud = 0;
    if (mark != std::string_view::npos) {
        const std::string_view query = rest.substr(mark + 1);
        if (!query.starts_with(kBaud)) {
            refuse(text);
        }
        baud = number(text, query.substr(kBaud.size()), 10'000'000);
    }
    if (rest.substr(0, mark).empty()) {
        refuse(text);
    }
    return std::make_unique<ByteLink>(port::open_serial(std::string(rest.substr(0, mark)), baud));
}

std::unique_ptr<HostLink> open_tcp(const std::string& text, std::string_view rest) {
    const std::size_t colon = rest.rfind(':');
    const bool has_address = colon != std::string_view::npos;
    const unsigned port = number(text, has_address ? rest.substr(colon + 1) : rest, 65535);
    const std::string address(has_address ? rest.substr(0, colon) : "127.0.0.1");
    return std::make_unique<ByteLink>(port::open_tcp(static_cast<std::uint16_t>(port), address));
}

}  // namespace

std::size_t ByteLink::receive(std::span<std::uint8_t, kLinkBytesPerTick> out) {
    const std::size_t n = port_->receive(out);
    counters_.bytes_in += n;
    return n;
}

void ByteLink::send(std::span<const std::uint8_t> bytes) {
    if (bytes.empty()) {
        return;
    }
    const std::size_t n = port_->send(bytes);
    counters_.bytes_out += n;
    counters_.lost += bytes.size() - n;
}

CanLink::CanLink(socketcan::CanSocket socket, bool fd, std::string name)
    : socket_(std::move(socket)), name_(std::move(name)), carrier_(socket_, fd) {}

std::size_t CanLink::receive(std::span<std::uint8_t, kLinkBytesPerTick> out) {
    const std::size_t size = carrier_.receive(out);
    counters_.bytes_in += size;
    return size;
}

void CanLink::send(std::span<const std::uint8_t> bytes) {
    const std::size_t taken = carrier_.send(bytes);
    counters_.bytes_out += taken;
    counters_.lost += bytes.size() - taken;
}

std::optional<int> inherited_file(std::string_view text) {
    if (!text.starts_with("fd:")) {
        return std::nullopt;
    }
    text.remove_prefix(3);
    int file = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), file);
    return error == std::errc{} && end == text.data() + text.size() && file > 2 ? std::optional(file) : std::nullopt;
}

std::unique_ptr<HostLink> open_host_link(const std::string& text) {
    const std::string_view all = text;
    const std::size_t colon = all.find(':');
    const std::string_view scheme = all.substr(0, colon);
    const std::string_view rest = colon == std::string_view::npos ? std::string_view{} : all.substr(colon + 1);
    if (scheme == "can") {
        return open_can(text, rest);
    }
    if (scheme == "serial") {
        return open_serial(text, rest);
    }
    if (scheme == "tcp") {
        return open_tcp(text, rest);
    }
    if (const std::optional<int> file = inherited_file(text)) {
        return std::make_unique<CanLink>(socketcan::CanSocket(*file), false, text);
    }
    refuse(text);
}

}  // namespace sc::linux_rt
