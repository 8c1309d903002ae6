// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cerrno>
#include <system_error>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include "boards/sim/port.hpp"

namespace sc::sim {
namespace {

class Tcp final : public Port {
public:
    explicit Tcp(std::uint16_t port) : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
        const int yes = 1;
        ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
        sockaddr_in address = loopback(port);
        socklen_t size = sizeof address;
        // NOLINTBEGIN(cppcoreguidelines-pro-type-reinterpret-cast): the socket interface wants it.
        auto* const generic = reinterpret_cast<sockaddr*>(&address);
        // NOLINTEND(cppcoreguidelines-pro-type-reinterpret-cast)
        if (listener_ < 0 || ::bind(listener_, generic, size) < 0 || ::listen(listener_, 1) < 0 ||
            ::getsockname(listener_, generic, &size) < 0) {
            const int error = errno;
            drop(listener_);
            throw std::system_error(error, std::generic_category(), "TCP port " + std::to_string(port));
        }
        port_ = ntohs(address.sin_port);
    }
    Tcp(const Tcp&) = delete;
    Tcp& operator=(const Tcp&) = delete;
    ~Tcp() override {
        drop(client_);
        drop(listener_);
    }

    [[nodiscard]] std::string name() const override { return std::to_string(port_); }
    [[nodiscard]] int file() const override { return client_ >= 0 ? client_ : listener_; }

    void receive(std::vector<std::uint8_t>& out) override {
        if (client_ < 0) {
            accept_client();
        }
        std::array<std::uint8_t, 4096> buffer{};
        while (client_ >= 0) {
            const ssize_t n = ::recv(client_, buffer.data(), buffer.size(), MSG_DONTWAIT);
            if (n > 0) {
                out.insert(out.end(), buffer.begin(), buffer.begin() + n);
            } else if (n < 0 && (errno == EAGAIN || errno == EINTR)) {
                return;
            } else {
                drop(client_);
            }
        }
    }

    void send(std::span<const std::uint8_t> bytes) override {
        if (client_ >= 0 && ::send(client_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT) < 0 &&
            errno != EAGAIN && errno != EINTR) {
            drop(client_);
        }
    }

private:
    static sockaddr_in loopback(std::uint16_t port) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        return address;
    }

    static void drop(int& file) {
        if (file >= 0) {
            ::close(file);
            file = -1;
        }
    }

    void accept_client() {
        client_ = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
        if (client_ >= 0) {
            const int yes = 1;
            ::setsockopt(client_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
        }
    }

    int listener_;
    int client_ = -1;
    std::uint16_t port_ = 0;
};

}  // namespace

std::unique_ptr<Port> open_tcp(std::uint16_t port) { return std::make_unique<Tcp>(port); }

}  // namespace sc::sim
