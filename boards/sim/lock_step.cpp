// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/lock_step.hpp"

#include <array>
#include <cerrno>
#include <span>

#include <sys/socket.h>
#include <unistd.h>

namespace sc::sim {
namespace {

constexpr std::size_t kHeader = 12;
constexpr std::uint64_t kFrameLimit = 1U << 24U;

std::uint64_t get(std::span<const std::uint8_t> bytes) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        value |= std::uint64_t{bytes[i]} << (8 * i);
    }
    return value;
}

void put(std::span<std::uint8_t> bytes, std::uint64_t value) {
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
}

bool read_all(int socket, std::span<std::uint8_t> bytes, const volatile bool* stop) {
    while (!bytes.empty()) {
        const ssize_t n = ::read(socket, bytes.data(), bytes.size());
        if (n > 0) {
            bytes = bytes.subspan(static_cast<std::size_t>(n));
        } else if (n == 0 || errno != EINTR || *stop) {
            return false;
        }
    }
    return true;
}

bool send_all(int socket, std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (n > 0) {
            bytes = bytes.subspan(static_cast<std::size_t>(n));
        } else if (n == 0 || errno != EINTR) {
            return false;
        }
    }
    return true;
}

void run(SimCell& cell, std::int64_t until_ns, std::vector<std::uint8_t>& answer) {
    answer.assign(kHeader, 0);
    while (cell.now_ns() < until_ns && cell.take_link(answer) == 0) {
        cell.tick();
    }
    cell.take_link(answer);
    put(std::span(answer).first(4), answer.size() - 4);
    put(std::span(answer).subspan(4, 8), static_cast<std::uint64_t>(cell.now_ns()));
}

}  // namespace

void serve_lock_step(SimCell& cell, int socket, const volatile bool* stop) {
    std::vector<std::uint8_t> received;
    std::vector<std::uint8_t> answer;
    std::array<std::uint8_t, kHeader> header{};
    while (!*stop && read_all(socket, header, stop)) {
        const std::uint64_t size = get(std::span(header).first(4));
        if (size < 8 || size > kFrameLimit) {
            return;
        }
        received.resize(size - 8);
        if (!read_all(socket, received, stop)) {
            return;
        }
        cell.push_link(received);
        run(cell, static_cast<std::int64_t>(get(std::span(header).subspan(4))), answer);
        if (!send_all(socket, answer)) {
            return;
        }
    }
}

}  // namespace sc::sim
