// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/lock_step.hpp"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <stdexcept>
#include <system_error>
#include <thread>

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
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

void kill_peer(int socket) {
    ucred peer{};
    socklen_t size = sizeof(peer);
    if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 && peer.pid > 1) {
        ::kill(peer.pid, SIGKILL);
    }
}

void run(LockStepCell& cell, std::int64_t until_ns, std::vector<std::uint8_t>& answer) {
    answer.assign(kHeader, 0);
    while (cell.now_ns() < until_ns && cell.take_link(answer) == 0) {
        cell.tick();
    }
    cell.take_link(answer);
    put(std::span(answer).first(4), answer.size() - 4);
    put(std::span(answer).subspan(4, 8), static_cast<std::uint64_t>(cell.now_ns()));
}

/// Serves one host until its socket closes. False once the cell has lost its power.
bool serve(LockStepCell& cell, int socket, const LockStepTroubles& troubles, bool& killed, const volatile bool* stop) {
    std::vector<std::uint8_t> received;
    std::vector<std::uint8_t> answer;
    std::array<std::uint8_t, kHeader> header{};
    while (!*stop && read_all(socket, header, stop)) {
        const std::uint64_t size = get(std::span(header).first(4));
        if (size < 8 || size > kFrameLimit) {
            return true;
        }
        received.resize(size - 8);
        if (!read_all(socket, received, stop)) {
            return true;
        }
        cell.push_link(received);
        run(cell, static_cast<std::int64_t>(get(std::span(header).subspan(4))), answer);
        if (troubles.power_off_ns > 0 && cell.now_ns() >= troubles.power_off_ns) {
            return false;
        }
        if (!send_all(socket, answer)) {
            return true;
        }
        if (!killed && troubles.kill_host_ns > 0 && cell.now_ns() >= troubles.kill_host_ns) {
            killed = true;
            std::this_thread::sleep_for(std::chrono::microseconds(troubles.kill_delay_us));
            kill_peer(socket);
        }
    }
    return true;
}

void live_alone(LockStepCell& cell, std::int64_t gap_ns) {
    const std::int64_t end = cell.now_ns() + gap_ns;
    while (cell.now_ns() < end) {
        cell.tick();
    }
    std::vector<std::uint8_t> unheard;
    cell.take_link(unheard);
}

/// A listening socket at a path; the file is removed at the end.
class Listener {
public:
    explicit Listener(const std::filesystem::path& path) : path_(path) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        // It takes its name once it listens: who finds it may connect.
        const std::string part = path.string() + ".part";
        if (part.size() >= sizeof(address.sun_path)) {
            throw std::invalid_argument("the path of the socket is too long: " + path.string());
        }
        part.copy(static_cast<char*>(address.sun_path), sizeof(address.sun_path) - 1);
        std::error_code ignored;
        std::filesystem::remove(part, ignored);
        file_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
        // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the form that bind wants
        const auto* pointer = reinterpret_cast<const sockaddr*>(&address);
        if (file_ < 0 || ::bind(file_, pointer, sizeof(address)) != 0 || ::listen(file_, 4) != 0) {
            throw std::system_error(errno, std::generic_category(), path.string());
        }
        std::filesystem::rename(part, path);
    }
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;
    ~Listener() {
        ::close(file_);
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
    }
    /// The next host's socket, −1 at the end.
    [[nodiscard]] int accept(const volatile bool* stop) const {
        while (!*stop) {
            pollfd wait{file_, POLLIN, 0};
            constexpr int kLookMs = 50;
            if (::poll(&wait, 1, kLookMs) > 0) {
                return ::accept4(file_, nullptr, nullptr, SOCK_CLOEXEC);
            }
        }
        return -1;
    }

private:
    std::filesystem::path path_;
    int file_ = -1;
};

}  // namespace

void serve_lock_step(LockStepCell& cell, int socket, const volatile bool* stop) {
    bool killed = true;
    (void)serve(cell, socket, {}, killed, stop);
}

bool serve_lock_step(LockStepCell& cell, const std::filesystem::path& path, const LockStepTroubles& troubles,
                     const volatile bool* stop) {
    const Listener listener(path);
    std::fprintf(stderr, "%s\n", path.c_str());  // not stdout: a host that started this cell may have its own say there
    bool killed = false;
    for (int host = listener.accept(stop); host >= 0; host = listener.accept(stop)) {
        const bool on = serve(cell, host, troubles, killed, stop);
        ::close(host);
        if (!on) {
            return false;
        }
        if (!*stop) {
            live_alone(cell, troubles.gap_ns);
        }
    }
    return true;
}

}  // namespace sc::sim
