// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/fd_transport.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>

namespace sc::host {
namespace {

/// Nobody reads on the other side: more than this is a dead link, not a slow one.
constexpr std::size_t kWaitingLimit = std::size_t{1} << 20U;

HostTime monotonic_now() {
    const auto since = std::chrono::steady_clock::now().time_since_epoch();
    return HostTime{std::chrono::duration_cast<Nanoseconds>(since)};
}

bool try_again() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

FdTransport::FdTransport(UniqueFd fd) : fd_(std::move(fd)) {
    const int flags = ::fcntl(fd_.get(), F_GETFL);
    ::fcntl(fd_.get(), F_SETFL, flags | O_NONBLOCK);
}

HostTime FdTransport::now() const { return monotonic_now(); }

void FdTransport::send(std::span<const std::uint8_t> bytes) {
    if (closed_) {
        return;
    }
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
    flush();
    closed_ = closed_ || waiting_.size() > kWaitingLimit;
}

void FdTransport::flush() {
    while (!waiting_.empty() && !closed_) {
        ssize_t n = ::send(fd_.get(), waiting_.data(), waiting_.size(), MSG_NOSIGNAL);
        if (n < 0 && errno == ENOTSOCK) {
            n = ::write(fd_.get(), waiting_.data(), waiting_.size());
        }
        if (n < 0) {
            closed_ = !try_again();
            return;
        }
        waiting_.erase(waiting_.begin(), waiting_.begin() + n);
    }
}

std::size_t FdTransport::receive(std::span<std::uint8_t> out, HostTime until) {
    while (!closed_) {
        flush();
        const ssize_t n = ::read(fd_.get(), out.data(), out.size());
        if (n > 0) {
            return static_cast<std::size_t>(n);
        }
        // A pseudo-terminal whose other end closed reads as EIO, a socket as end of file.
        if (n == 0 || !try_again()) {
            closed_ = true;
            return 0;
        }
        const Nanoseconds left = until - monotonic_now();
        if (left <= Nanoseconds::zero()) {
            return 0;
        }
        pollfd wait{fd_.get(), POLLIN, 0};
        if (!waiting_.empty()) {
            wait.events |= POLLOUT;
        }
        timespec timeout{};
        timeout.tv_sec = left.count() / 1'000'000'000;
        timeout.tv_nsec = left.count() % 1'000'000'000;
        if (::ppoll(&wait, 1, &timeout, nullptr) < 0 && errno == EINTR) {
            return 0;
        }
    }
    return 0;
}

}  // namespace sc::host
