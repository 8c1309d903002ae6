// SPDX-License-Identifier: Apache-2.0
#include "boards/port/port.hpp"

#include <array>
#include <chrono>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sc::port {
namespace {

std::vector<std::uint8_t> wait_for(Port& port, std::size_t count) {
    std::vector<std::uint8_t> got;
    std::array<std::uint8_t, 64> chunk{};
    for (int i = 0; i < 2000 && got.size() < count; ++i) {
        const std::size_t n = port.receive(chunk);
        got.insert(got.end(), chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(n));
        if (n == 0) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }
    return got;
}

TEST(SerialPort, TalksOverAPseudoTerminal) {
    const auto master = open_pty();
    const auto line = open_serial(master->name(), 115'200);
    const std::vector<std::uint8_t> bytes{0, 3, 10, 13, 17, 19, 255};
    EXPECT_EQ(master->send(bytes), bytes.size());
    EXPECT_EQ(wait_for(*line, bytes.size()), bytes);
    EXPECT_EQ(line->send(bytes), bytes.size());
    EXPECT_EQ(wait_for(*master, bytes.size()), bytes);
    EXPECT_EQ(line->name(), master->name());
}

TEST(SerialPort, RefusesWhatIsNoneAndSpeedsThatAreNone) {
    EXPECT_THROW(static_cast<void>(open_serial("/dev/there_is_none", 0)), std::system_error);
    EXPECT_THROW(static_cast<void>(open_serial("/dev/null", 0)), std::invalid_argument);
    const auto master = open_pty();
    EXPECT_THROW(static_cast<void>(open_serial(master->name(), 12'345)), std::invalid_argument);
}

TEST(TcpPort, ServesOneClientAfterAnother) {
    const auto port = open_tcp(0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(port->name())));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(port->send(std::vector<std::uint8_t>{1}), 0U);
    for (int client = 0; client < 2; ++client) {
        const int file = ::socket(AF_INET, SOCK_STREAM, 0);
        ASSERT_EQ(::connect(file, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
        const std::vector<std::uint8_t> bytes{7, 8, static_cast<std::uint8_t>(client)};
        ASSERT_EQ(::send(file, bytes.data(), bytes.size(), 0), 3);
        EXPECT_EQ(wait_for(*port, 3), bytes);
        EXPECT_EQ(port->send(bytes), 3U);
        std::array<std::uint8_t, 3> back{};
        EXPECT_EQ(::recv(file, back.data(), back.size(), MSG_WAITALL), 3);
        ::close(file);
        std::array<std::uint8_t, 8> nothing{};
        for (int i = 0; i < 100; ++i) {
            EXPECT_EQ(port->receive(nothing), 0U);
        }
    }
}

TEST(TcpPort, RefusesAnAddressThatIsNone) {
    EXPECT_THROW(static_cast<void>(open_tcp(0, "nowhere")), std::invalid_argument);
}

}  // namespace
}  // namespace sc::port
