// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/service_notify.hpp"

#include <charconv>
#include <cstddef>
#include <cstdlib>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace sc::linux_rt {
namespace {

std::optional<std::int64_t> number_of(const char* name) {
    const char* text = std::getenv(name);
    if (text == nullptr) {
        return std::nullopt;
    }
    const std::string_view all = text;
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(all.data(), all.data() + all.size(), value);
    return error == std::errc{} && end == all.data() + all.size() ? std::optional(value) : std::nullopt;
}

}  // namespace

ServiceNotify::ServiceNotify() {
    if (const char* socket = std::getenv("NOTIFY_SOCKET"); socket != nullptr && socket[0] != '\0') {
        socket_ = socket;
        file_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    }
    const auto us = number_of("WATCHDOG_USEC");
    const auto process = number_of("WATCHDOG_PID");
    if (us && *us > 0 && (!process || *process == ::getpid())) {
        watchdog_ns_ = *us * 1000 / 2;
    }
}

ServiceNotify::~ServiceNotify() {
    if (file_ >= 0) {
        ::close(file_);
    }
}

bool ServiceNotify::say(std::string_view words) const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (file_ < 0 || socket_.size() >= sizeof address.sun_path) {
        return false;
    }
    socket_.copy(static_cast<char*>(address.sun_path), socket_.size());
    if (address.sun_path[0] == '@') {
        address.sun_path[0] = '\0';  // of the abstract kind
    }
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + socket_.size());
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the socket interface wants it.
    const auto* to = reinterpret_cast<const sockaddr*>(&address);
    return ::sendto(file_, words.data(), words.size(), MSG_NOSIGNAL, to, size) == static_cast<ssize_t>(words.size());
}

}  // namespace sc::linux_rt
