// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "image_path.hpp"
#include "shared/codes/codes.hpp"
#include "shared/codes/state.hpp"
#include "shared/link/messages.hpp"
#include "shared/link/schema.hpp"
#include "shared/link/serial.hpp"

namespace sc::mps2_an500 {
namespace {

using Clock = std::chrono::steady_clock;

/// The board alone, without a PC behind its PSRAM: the controller runs by the board's clock, UART0 is a socket.
class FreeBoard {
public:
    FreeBoard() {
        std::array<int, 2> pair{};
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, pair.data()), 0);
        socket_ = pair[0];
        const std::string chardev = "socket,id=uart,fd=" + std::to_string(pair[1]);
        qemu_.emplace("qemu-system-arm", std::vector<std::string>{"-M", "mps2-an500", "-icount", "shift=2", "-kernel",
                                                                  SC_M7_IMAGE, "-nographic", "-monitor", "none",
                                                                  "-chardev", chardev, "-serial", "chardev:uart"});
        ::close(pair[1]);
    }
    FreeBoard(const FreeBoard&) = delete;
    FreeBoard& operator=(const FreeBoard&) = delete;
    ~FreeBoard() { ::close(socket_); }

    template <class Message>
    void send(const Message& message) {
        std::array<std::uint8_t, link::kSerialCapacity> out{};
        const std::size_t size = link::encode_serial(message, counter_++, out);
        EXPECT_EQ(::write(socket_, out.data(), size), static_cast<ssize_t>(size));
    }
    /// The next message of this kind; others are passed over. nullopt after 20 s.
    template <class Message>
    std::optional<Message> receive() {
        std::optional<Message> found;
        const Clock::time_point end = Clock::now() + std::chrono::seconds(20);
        while (!found && Clock::now() < end) {
            pollfd wait{socket_, POLLIN, 0};
            ::poll(&wait, 1, 100);
            std::array<std::uint8_t, 256> bytes{};
            const ssize_t n = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
            receiver_.receive(std::span(bytes).first(n > 0 ? static_cast<std::size_t>(n) : 0),
                              [&found](const link::Envelope& envelope) {
                                  (void)link::dispatch(link::MessageList<Message>{}, envelope,
                                                       [&found](const Message& m) { found = m; });
                              });
        }
        return found;
    }

private:
    int socket_ = -1;
    std::optional<QemuProcess> qemu_;
    link::SerialReceiver receiver_;
    std::uint16_t counter_ = 0;
};

TEST(Uart, ControllerAnswersOverTheRealUart) {
    FreeBoard board;
    link::Hello hello;
    hello.schema = link::kSchemaHash ^ 1U;
    hello.session = 7;
    hello.heartbeat_timeout_ms = 500;
    board.send(hello);
    const auto refused = board.receive<link::HelloReply>();
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->refusal, static_cast<std::uint16_t>(Refusal::schema_mismatch));

    hello.schema = link::kSchemaHash;
    board.send(hello);
    const auto reply = board.receive<link::HelloReply>();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->refusal, 0);
    EXPECT_EQ(reply->schema, link::kSchemaHash);

    // Nothing else is wired: the emergency stop reads as a broken wire, and without drives the controller stays in
    // boot.
    board.send(link::Command{1, static_cast<std::uint8_t>(link::Verb::enable), 0, 0, 0});
    const auto answer = board.receive<link::CommandReply>();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->sequence, 1U);
    EXPECT_EQ(answer->refusal, static_cast<std::uint16_t>(Refusal::estop_open));
    const auto status = board.receive<link::Status>();
    const auto later = board.receive<link::Status>();
    ASSERT_TRUE(status && later);
    EXPECT_EQ(status->state, static_cast<std::uint8_t>(State::boot));
    EXPECT_GT(later->cell_time_us, status->cell_time_us) << "it runs by the board's own clock";
    EXPECT_EQ(later->frames_bad, 0U);
}

}  // namespace
}  // namespace sc::mps2_an500
