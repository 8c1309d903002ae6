// SPDX-License-Identifier: Apache-2.0
#include "boards/event_device/event_link.hpp"

#include <algorithm>
#include <cerrno>
#include <system_error>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace sc::event_device {
namespace {

/// Room for windows of some ten milliseconds.
constexpr int kSendBytes = 1 << 20;

int connect_to(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.empty() || path.size() >= sizeof address.sun_path) {
        throw std::system_error(ENAMETOOLONG, std::generic_category(), "event device " + path);
    }
    path.copy(static_cast<char*>(address.sun_path), sizeof address.sun_path - 1);
    const int file = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the socket interface wants it.
    if (file < 0 || ::connect(file, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        const int error = errno;
        ::close(file);
        throw std::system_error(error, std::generic_category(),
                                "event device " + path + " (start one with scribecell-events " + path + ")");
    }
    return file;
}

}  // namespace

EventLink::EventLink(const std::string& path, const MachineConfig& machine) : EventLink(connect_to(path), machine) {}

EventLink::EventLink(int file, const MachineConfig& machine) : file_(file) {
    (void)::setsockopt(file_, SOL_SOCKET, SO_SNDBUF, &kSendBytes, sizeof kSendBytes);
    if (!put(put_begin(machine, buffer_))) {
        ::close(file_);
        throw std::system_error(errno, std::generic_category(), "event device");
    }
}

EventLink::~EventLink() { ::close(file_); }

bool EventLink::put(std::size_t size) noexcept {
    return size > 0 && !lost_ && ::send(file_, buffer_.data(), size, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0;
}

void EventLink::send(std::int64_t tick, const ServoOutputs& outputs) noexcept {
    if (lost_) {
        return;
    }
    if (put(put_window(tick, outputs, buffer_))) {
        ++counters_.windows;
        return;
    }
    counters_.full += errno == EAGAIN ? 1 : 0;
    lost_ = true;
    // The device sees its controller go and shuts its gate.
    ::shutdown(file_, SHUT_RDWR);
}

void EventLink::veto(std::uint8_t causes) noexcept {
    std::array<std::uint8_t, 2> packet{};
    const std::size_t size = put_veto(causes, packet);
    if (::send(file_, packet.data(), size, MSG_DONTWAIT | MSG_NOSIGNAL) < 0 && causes != 0) {
        ::shutdown(file_, SHUT_RDWR);
    }
}

bool EventLink::receive(Status& out) noexcept {
    std::array<std::uint8_t, kStatusCapacity + 1> packet{};
    std::array<std::uint8_t, kSourceBytesPerTick> source{};
    std::size_t held = 0;
    bool heard = false;
    while (!lost_) {
        const ssize_t n = ::recv(file_, packet.data(), packet.size(), MSG_DONTWAIT);
        if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) {
            lost_ = true;
        }
        if (n <= 0) {
            break;
        }
        if (!get_status(std::span(packet).first(static_cast<std::size_t>(n)), out)) {
            ++counters_.malformed;
            continue;
        }
        const std::size_t more = std::min(out.source_size, source.size() - held);
        std::copy_n(out.source.begin(), more, source.begin() + static_cast<std::ptrdiff_t>(held));
        held += more;
        heard = true;
        ++counters_.statuses;
    }
    out.source = source;
    out.source_size = held;
    return heard;
}

}  // namespace sc::event_device
