// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/lock_step.hpp"

#include <array>
#include <cstring>
#include <filesystem>
#include <thread>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "boards/sim/cell.hpp"

namespace sc::sim {
namespace {

struct Answer {
    std::int64_t now_ns = -1;
    std::vector<std::uint8_t> bytes;
};

class LockStepServer : public testing::Test {
protected:
    LockStepServer() {
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, sockets_.data()), 0);
        CellOptions options;
        options.world = std::filesystem::path(SC_SOURCE_DIR) / "boards/sim/world/default/world.toml";
        cell_ = std::make_unique<SimCell>(options);
        server_ = std::thread([this] { serve_lock_step(*cell_, sockets_[1], &stop_); });
    }
    ~LockStepServer() override {
        hang_up();
        ::close(sockets_[1]);
    }
    void hang_up() {
        if (server_.joinable()) {
            ::close(sockets_[0]);
            server_.join();
        }
    }
    /// A request without bytes for the cell.
    void send(std::uint32_t n, std::int64_t until_ns) const {
        std::array<std::uint8_t, 12> frame{};
        std::memcpy(frame.data(), &n, 4);
        std::memcpy(frame.data() + 4, &until_ns, 8);
        ASSERT_EQ(::send(sockets_[0], frame.data(), frame.size(), MSG_NOSIGNAL), 12);
    }
    Answer exchange(std::int64_t until_ns) const {
        send(8, until_ns);
        std::array<std::uint8_t, 12> header{};
        if (::recv(sockets_[0], header.data(), header.size(), MSG_WAITALL) != 12) {
            return {};
        }
        std::uint32_t n = 0;
        Answer answer;
        std::memcpy(&n, header.data(), 4);
        std::memcpy(&answer.now_ns, header.data() + 4, 8);
        answer.bytes.resize(n - 8);
        if (!answer.bytes.empty()) {
            EXPECT_EQ(::recv(sockets_[0], answer.bytes.data(), answer.bytes.size(), MSG_WAITALL),
                      static_cast<ssize_t>(answer.bytes.size()));
        }
        return answer;
    }

    std::array<int, 2> sockets_{-1, -1};
    volatile bool stop_ = false;
    std::unique_ptr<SimCell> cell_;
    std::thread server_;
};

TEST_F(LockStepServer, RunsUntilTheTimeAskedForAndNoFurther) {
    std::int64_t now = 0;
    while (now < 50'000'000) {
        const Answer answer = exchange(50'000'000);
        ASSERT_GT(answer.now_ns, now);
        if (answer.now_ns < 50'000'000) {
            EXPECT_FALSE(answer.bytes.empty()) << "stops early only to hand bytes over";
        }
        now = answer.now_ns;
    }
    EXPECT_EQ(now, 50'000'000);
    EXPECT_EQ(exchange(10'000'000).now_ns, 50'000'000) << "never back in time";
}

TEST_F(LockStepServer, EndsWhenTheHostHangsUp) {
    (void)exchange(5'000'000);
    hang_up();
    EXPECT_EQ(cell_->now_ns(), 5'000'000);
}

TEST_F(LockStepServer, RefusesAFrameThatIsNone) {
    send(7, 0);
    std::array<std::uint8_t, 1> byte{};
    server_.join();
    ::shutdown(sockets_[1], SHUT_RDWR);
    EXPECT_EQ(::recv(sockets_[0], byte.data(), 1, 0), 0);
    ::close(sockets_[0]);
}

}  // namespace
}  // namespace sc::sim
