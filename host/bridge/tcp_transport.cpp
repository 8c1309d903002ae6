// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <cstring>
#include <utility>

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include "host/bridge/errors.hpp"
#include "host/bridge/fd_transport.hpp"

namespace sc::host {
namespace {

using Addresses = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

Addresses resolve(const std::string& host, std::uint16_t port) {
    addrinfo wanted{};
    wanted.ai_family = AF_UNSPEC;
    wanted.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    const int failed = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found);
    if (failed != 0) {
        throw LinkError("no such host as " + host + ": " + ::gai_strerror(failed));
    }
    return {found, &::freeaddrinfo};
}

}  // namespace

std::unique_ptr<Transport> open_tcp(const std::string& host, std::uint16_t port) {
    const Addresses addresses = resolve(host, port);
    int error = 0;
    for (const addrinfo* a = addresses.get(); a != nullptr; a = a->ai_next) {
        UniqueFd fd(::socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC, a->ai_protocol));
        if (!fd.valid() || ::connect(fd.get(), a->ai_addr, a->ai_addrlen) != 0) {
            error = errno;
            continue;
        }
        const int on = 1;
        ::setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
        return std::make_unique<FdTransport>(std::move(fd));
    }
    throw LinkError("no cell answers at " + host + ":" + std::to_string(port) + " (" + std::strerror(error) +
                    "): start one with `scribecell cell --tcp " + std::to_string(port) + "`, or check the address");
}

}  // namespace sc::host
