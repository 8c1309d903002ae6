// SPDX-License-Identifier: Apache-2.0
#include "host/cli/live_page.hpp"

#include <array>
#include <cerrno>
#include <string_view>
#include <system_error>

#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>

namespace sc::host::cli {
namespace {

constexpr int kQueue = 8;
constexpr const char* kPage = R"(<!doctype html><meta charset="utf-8"><title>scribecell measure</title>
<style>body{margin:16px;background:#eef1f4;font:14px sans-serif}img{background:#fff;max-width:100%;
box-shadow:0 1px 4px #0003}</style><img id="v" src="view.svg" alt="station"><p id="s"></p><script>
const v=document.getElementById("v"),s=document.getElementById("s");let n=0;
setInterval(()=>{const i=new Image();i.onload=()=>{v.src=i.src;s.textContent="";};
i.onerror=()=>{s.textContent="the measurement has ended";};i.src="view.svg?"+(++n);},500);</script>
)";

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

void send_all(int client, std::string_view text) {
    while (!text.empty()) {
        const ssize_t sent = ::send(client, text.data(), text.size(), MSG_NOSIGNAL);
        if (sent <= 0) {
            return;  // whoever asked has gone
        }
        text.remove_prefix(static_cast<std::size_t>(sent));
    }
}

std::string reply(const char* status, const char* type, std::string_view body) {
    return fmt::format(
        "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nCache-Control: no-store\r\nConnection: "
        "close\r\n\r\n{}",
        status, type, body.size(), body);
}

}  // namespace

LivePage::LivePage(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    if (socket_.get() < 0) {
        fail("a socket for the page");
    }
    const int yes = 1;
    static_cast<void>(::setsockopt(socket_.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): as the sockets' interface wants it.
    auto* any = reinterpret_cast<sockaddr*>(&address);
    socklen_t size = sizeof address;
    if (::bind(socket_.get(), any, size) != 0 || ::listen(socket_.get(), kQueue) != 0 ||
        ::getsockname(socket_.get(), any, &size) != 0) {
        fail("the page's port on loopback");
    }
    port_ = ntohs(address.sin_port);
}

void LivePage::answer(int client) const {
    // A client that says nothing must not hold up the measurement.
    const timeval patience{.tv_sec = 0, .tv_usec = 200'000};
    static_cast<void>(::setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience));
    static_cast<void>(::setsockopt(client, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience));
    std::array<char, 2048> buffer{};
    const ssize_t got = ::recv(client, buffer.data(), buffer.size(), 0);
    const std::string_view request(buffer.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
    if (request.starts_with("GET /view.svg")) {
        send_all(client, reply("200 OK", "image/svg+xml", svg_));
    } else if (request.starts_with("GET / ")) {
        send_all(client, reply("200 OK", "text/html", kPage));
    } else {
        send_all(client, reply("404 Not Found", "text/plain", "there is / and /view.svg\n"));
    }
}

void LivePage::serve(int milliseconds) {
    pollfd waiting{.fd = socket_.get(), .events = POLLIN, .revents = 0};
    while (::poll(&waiting, 1, milliseconds) > 0) {
        const UniqueFd client(::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC));
        if (client.get() >= 0) {
            answer(client.get());
        }
        milliseconds = 0;
    }
}

}  // namespace sc::host::cli
