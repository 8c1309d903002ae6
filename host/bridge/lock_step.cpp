// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/lock_step.hpp"

#include <array>
#include <cerrno>
#include <cstddef>

#include <poll.h>
#include <sys/socket.h>

namespace sc::host {
namespace {

constexpr int kSilenceMs = 30'000;
constexpr std::size_t kHeader = 12;
/// More than a cell can have to say in one exchange: a frame of that size is garbage.
constexpr std::uint32_t kFrameLimit = 1U << 24U;

template <class Integer>
void put(std::uint8_t* out, Integer value) {
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
        out[i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
}

template <class Integer>
Integer get(const std::uint8_t* in) {
    Integer value = 0;
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
        value |= static_cast<Integer>(in[i]) << (8 * i);
    }
    return value;
}

bool send_all(int socket, std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            return false;
        }
        bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
    return true;
}

bool receive_all(int socket, std::span<std::uint8_t> bytes) {
    while (!bytes.empty()) {
        pollfd wait{socket, POLLIN, 0};
        const int ready = ::poll(&wait, 1, kSilenceMs);
        if (ready == 0 || (ready < 0 && errno != EINTR)) {
            return false;
        }
        const ssize_t n = ::recv(socket, bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (n < 0 && (errno == EINTR || errno == EAGAIN)) {
            continue;
        }
        if (n <= 0) {
            return false;
        }
        bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
    return true;
}

}  // namespace

bool LockStep::exchange(std::span<const std::uint8_t> bytes, Nanoseconds run_until,
                        std::vector<std::uint8_t>& received) {
    std::vector<std::uint8_t> request(kHeader);
    put(request.data(), static_cast<std::uint32_t>(bytes.size() + 8));
    put(request.data() + 4, static_cast<std::uint64_t>(run_until.count()));
    request.insert(request.end(), bytes.begin(), bytes.end());
    std::array<std::uint8_t, kHeader> header{};
    if (!send_all(socket_, request) || !receive_all(socket_, header)) {
        return false;
    }
    const auto size = get<std::uint32_t>(header.data());
    const HostTime told{Nanoseconds(static_cast<std::int64_t>(get<std::uint64_t>(header.data() + 4)))};
    if (size < 8 || size > kFrameLimit || told < now_) {
        return false;
    }
    const std::size_t before = received.size();
    received.resize(before + (size - 8));
    if (!receive_all(socket_, std::span(received).subspan(before))) {
        received.resize(before);
        return false;
    }
    now_ = told;
    return true;
}

}  // namespace sc::host
