// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <stdexcept>
#include <string>
#include <system_error>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include "boards/port/port.hpp"

namespace sc::port {
namespace {

class Tcp final : public Port {
public:
    Tcp(std::uint16_t port, const std::string& where)
        : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
        const int yes = 1;
        ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
        sockaddr_in address = place(port, where);
        socklen_t size = sizeof address;
        // NOLINTBEGIN(cppcoreguidelines-pro-type-reinterpret-cast): the socket interface wants it.
        auto* const generic = reinterpret_cast<sockaddr*>(&address);
        // NOLINTEND(cppcoreguidelines-pro-type-reinterpret-cast)
        if (listener_ < 0 || ::bind(listener_, generic, size) < 0 || ::listen(listener_, 1) < 0 ||
            ::getsockname(listener_, generic, &size) < 0) {
            const int error = errno;
            drop(listener_);
            throw std::system_error(error, std::generic_category(), "TCP port " + where + ":" + std::to_string(port));
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

    std::size_t receive(std::span<std::uint8_t> out) override {
        if (client_ < 0) {
            accept_client();
        }
        if (client_ < 0 || out.empty()) {
            return 0;
        }
        const ssize_t n = ::recv(client_, out.data(), out.size(), MSG_DONTWAIT);
        if (n > 0) {
            return static_cast<std::size_t>(n);
        }
        if (n == 0 || (errno != EAGAIN && errno != EINTR)) {
            drop(client_);
        }
        return 0;
    }

    std::size_t send(std::span<const std::uint8_t> bytes) override {
        if (client_ < 0) {
            return 0;
        }
        const ssize_t n = ::send(client_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n < 0 && errno != EAGAIN && errno != EINTR) {
            drop(client_);
        }
        return n > 0 ? static_cast<std::size_t>(n) : 0;
    }

private:
    static sockaddr_in place(std::uint16_t port, const std::string& where) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        if (::inet_pton(AF_INET, where.c_str(), &address.sin_addr) != 1) {
            throw std::invalid_argument("'" + where + "' is no IPv4 address");
        }
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

std::unique_ptr<Port> open_tcp(std::uint16_t port, const std::string& address) {
    return std::make_unique<Tcp>(port, address);
}

}  // namespace sc::port
