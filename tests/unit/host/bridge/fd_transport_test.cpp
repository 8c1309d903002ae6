// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/fd_transport.hpp"

#include <array>
#include <cstring>
#include <numeric>
#include <string>

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <termios.h>

#include "host/bridge/errors.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr Nanoseconds kLong{5'000'000'000};
constexpr Nanoseconds kShort{2'000'000};

std::vector<std::uint8_t> all_bytes() {
    std::vector<std::uint8_t> bytes(256);
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
    return bytes;
}

std::vector<std::uint8_t> receive(Transport& from, std::size_t count) {
    std::vector<std::uint8_t> bytes;
    std::array<std::uint8_t, 64> chunk{};
    const HostTime end = from.now() + kLong;
    while (bytes.size() < count && from.now() < end && !from.closed()) {
        const std::size_t n = from.receive(chunk, end);
        bytes.insert(bytes.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(n));
    }
    return bytes;
}

std::vector<std::uint8_t> read_raw(int fd, std::size_t count) {
    std::vector<std::uint8_t> bytes(count);
    std::size_t got = 0;
    while (got < count) {
        const ssize_t n = ::read(fd, bytes.data() + got, count - got);
        if (n <= 0) {
            break;
        }
        got += static_cast<std::size_t>(n);
    }
    bytes.resize(got);
    return bytes;
}

struct PseudoTerminal {
    UniqueFd master{::posix_openpt(O_RDWR | O_NOCTTY)};
    std::string name;
    PseudoTerminal() {
        ::grantpt(master.get());
        ::unlockpt(master.get());
        name = ::ptsname(master.get());
    }
};

struct Listener {
    UniqueFd fd{::socket(AF_INET, SOCK_STREAM, 0)};
    std::uint16_t port = 0;
    Listener() {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof(address);
        sockaddr generic{};
        std::memcpy(&generic, &address, sizeof(address));
        ::bind(fd.get(), &generic, size);
        ::listen(fd.get(), 1);
        ::getsockname(fd.get(), &generic, &size);
        std::memcpy(&address, &generic, sizeof(address));
        port = ntohs(address.sin_port);
    }
};

TEST(FdTransport, PseudoTerminalCarriesEveryByteUnchangedBothWays) {
    const PseudoTerminal terminal;
    const auto link = open_serial(terminal.name, 0);
    link->send(all_bytes());
    EXPECT_EQ(read_raw(terminal.master.get(), 256), all_bytes());
    ASSERT_EQ(::write(terminal.master.get(), all_bytes().data(), 256), 256);
    EXPECT_EQ(receive(*link, 256), all_bytes());
    EXPECT_FALSE(link->closed());
}

TEST(FdTransport, PseudoTerminalTakesASpeed) {
    const PseudoTerminal terminal;
    const auto link = open_serial(terminal.name, 921600);
    termios settings{};
    ASSERT_EQ(::tcgetattr(terminal.master.get(), &settings), 0);
    EXPECT_EQ(::cfgetospeed(&settings), static_cast<speed_t>(B921600));
    EXPECT_THROW(static_cast<void>(open_serial(terminal.name, 12345)), InputError);
}

TEST(FdTransport, NoticesThatTheTerminalsOtherEndHasGone) {
    PseudoTerminal terminal;
    const auto link = open_serial(terminal.name, 0);
    terminal.master.reset();
    std::array<std::uint8_t, 8> bytes{};
    EXPECT_EQ(link->receive(bytes, link->now() + kLong), 0U);
    EXPECT_TRUE(link->closed());
}

TEST(FdTransport, RefusesWhatIsNoSerialLine) {
    EXPECT_THROW(static_cast<void>(open_serial("/dev/no-such-line", 0)), InputError);
    EXPECT_THROW(static_cast<void>(open_serial("/dev/null", 0)), InputError);
}

TEST(FdTransport, TcpCarriesEveryByteBothWaysAndNoticesTheEnd) {
    const Listener listener;
    const auto link = open_tcp("127.0.0.1", listener.port);
    UniqueFd peer(::accept(listener.fd.get(), nullptr, nullptr));
    link->send(all_bytes());
    EXPECT_EQ(read_raw(peer.get(), 256), all_bytes());
    ASSERT_EQ(::write(peer.get(), all_bytes().data(), 256), 256);
    EXPECT_EQ(receive(*link, 256), all_bytes());
    peer.reset();
    std::array<std::uint8_t, 8> bytes{};
    EXPECT_EQ(link->receive(bytes, link->now() + kLong), 0U);
    EXPECT_TRUE(link->closed());
}

TEST(FdTransport, SaysWhenNobodyListens) {
    std::uint16_t port = 0;
    {
        const Listener listener;
        port = listener.port;
    }
    EXPECT_THROW(static_cast<void>(open_tcp("127.0.0.1", port)), LinkError);
}

TEST(FdTransport, WaitsUntilTheTimeGiven) {
    const Listener listener;
    const auto link = open_tcp("127.0.0.1", listener.port);
    const HostTime until = link->now() + kShort;
    std::array<std::uint8_t, 8> bytes{};
    EXPECT_EQ(link->receive(bytes, until), 0U);
    EXPECT_GE(link->now(), until);
    EXPECT_FALSE(link->closed());
}

TEST(FdTransport, SendingNeverBlocksOnAPeerThatDoesNotRead) {
    const Listener listener;
    const auto link = open_tcp("127.0.0.1", listener.port);
    const UniqueFd peer(::accept(listener.fd.get(), nullptr, nullptr));
    const std::vector<std::uint8_t> chunk(65536, 0x5A);
    for (int i = 0; i < 400 && !link->closed(); ++i) {
        link->send(chunk);
    }
    EXPECT_TRUE(link->closed());
}

}  // namespace
}  // namespace sc::host
