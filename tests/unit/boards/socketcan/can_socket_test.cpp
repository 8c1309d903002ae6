// SPDX-License-Identifier: Apache-2.0
#include "boards/socketcan/can_socket.hpp"

#include <array>
#include <ctime>
#include <system_error>
#include <utility>

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sc::socketcan {
namespace {

/// One end in a CanSocket, the other bare, for what the kernel would put there.
class CanSocketTest : public testing::Test {
protected:
    CanSocketTest() : socket_(make()) {}
    ~CanSocketTest() override { hang_up(); }

    int make() {
        std::array<int, 2> files{};
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0, files.data()), 0);
        peer_ = files[1];
        return files[0];
    }
    void hang_up() {
        if (peer_ >= 0) {
            ::close(peer_);
            peer_ = -1;
        }
    }
    void put(const void* bytes, std::size_t size) const {
        ASSERT_EQ(::send(peer_, bytes, size, 0), static_cast<ssize_t>(size));
    }
    void put_error(std::uint32_t id, std::uint8_t detail = 0, std::uint8_t tx = 0, std::uint8_t rx = 0) const {
        can_frame raw{};
        raw.can_id = id | CAN_ERR_FLAG;
        raw.can_dlc = 8;
        raw.data[1] = detail;
        raw.data[6] = tx;
        raw.data[7] = rx;
        put(&raw, sizeof raw);
    }

    int peer_ = -1;
    CanSocket socket_;
};

TEST_F(CanSocketTest, SendsTheKernelsOwnStructures) {
    CanFrame frame;
    frame.id = 0x123;
    frame.size = 3;
    frame.data = {1, 2, 3};
    ASSERT_EQ(socket_.send(frame), CanSent::yes);
    can_frame raw{};
    ASSERT_EQ(::recv(peer_, &raw, sizeof raw, 0), static_cast<ssize_t>(CAN_MTU));
    EXPECT_EQ(raw.can_id, 0x123U);
    EXPECT_EQ(raw.can_dlc, 3);
    EXPECT_EQ(raw.data[2], 3);

    frame.fd = true;
    frame.fast = true;
    frame.extended = true;
    frame.size = 48;
    frame.data[47] = 9;
    ASSERT_EQ(socket_.send(frame), CanSent::yes);
    canfd_frame long_raw{};
    ASSERT_EQ(::recv(peer_, &long_raw, sizeof long_raw, 0), static_cast<ssize_t>(CANFD_MTU));
    EXPECT_EQ(long_raw.can_id, 0x123U | CAN_EFF_FLAG);
    EXPECT_EQ(long_raw.flags, CANFD_BRS);
    EXPECT_EQ(long_raw.len, 48);
    EXPECT_EQ(long_raw.data[47], 9);
    EXPECT_EQ(socket_.counters().sent, 2U);
}

TEST_F(CanSocketTest, HearsFramesWithTheirTimeAndNothingElse) {
    CanFrame heard;
    EXPECT_FALSE(socket_.receive(heard));
    can_frame raw{};
    raw.can_id = 0x80;
    raw.can_dlc = 1;
    raw.data[0] = 7;
    const std::time_t before = std::time(nullptr);
    put(&raw, sizeof raw);
    put(&raw, 5);  // no frame
    canfd_frame odd{};
    odd.len = 13;  // a size that FD frames do not have
    put(&odd, sizeof odd);
    canfd_frame long_raw{};
    long_raw.can_id = 0x18FF1234U | CAN_EFF_FLAG;
    long_raw.len = 64;
    long_raw.data[63] = 5;
    put(&long_raw, sizeof long_raw);
    ASSERT_TRUE(socket_.receive(heard));
    EXPECT_EQ(heard.id, 0x80U);
    EXPECT_EQ(heard.size, 1);
    EXPECT_FALSE(heard.fd);
    EXPECT_GE(heard.time_ns / 1'000'000'000, before - 1);
    EXPECT_LE(heard.time_ns / 1'000'000'000, std::time(nullptr) + 1);
    ASSERT_TRUE(socket_.receive(heard));
    EXPECT_TRUE(heard.fd && heard.extended);
    EXPECT_EQ(heard.id, 0x18FF1234U);
    EXPECT_EQ(heard.data[63], 5);
    EXPECT_FALSE(socket_.receive(heard));
    EXPECT_EQ(socket_.counters().malformed, 2U);
    EXPECT_EQ(socket_.counters().received, 2U);
}

TEST_F(CanSocketTest, RefusesSizesThatNoFrameHas) {
    CanFrame frame;
    frame.size = 9;
    EXPECT_EQ(socket_.send(frame), CanSent::failed);
    frame.fd = true;
    frame.size = 13;
    EXPECT_EQ(socket_.send(frame), CanSent::failed);
    EXPECT_EQ(socket_.counters().failed, 2U);
}

TEST_F(CanSocketTest, CountsAFullQueueAndGoesOnAfterIt) {
    CanFrame frame;
    frame.size = 8;
    int sent = 0;
    while (sent < 100'000 && socket_.send(frame) == CanSent::yes) {
        ++sent;
    }
    ASSERT_LT(sent, 100'000);
    EXPECT_EQ(socket_.counters().full, 1U);
    can_frame raw{};
    while (::recv(peer_, &raw, sizeof raw, MSG_DONTWAIT) > 0) {
    }
    EXPECT_EQ(socket_.send(frame), CanSent::yes);
}

TEST_F(CanSocketTest, ErrorFramesTellTheStateOfTheBus) {
    CanFrame heard;
    put_error(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_WARNING, 100, 3);
    EXPECT_FALSE(socket_.receive(heard));
    EXPECT_EQ(socket_.state(), BusState::warning);
    EXPECT_EQ(socket_.counters().tx_error_count, 100);
    EXPECT_EQ(socket_.counters().rx_error_count, 3);
    put_error(CAN_ERR_CRTL | CAN_ERR_ACK, CAN_ERR_CRTL_TX_PASSIVE, 128, 0);
    EXPECT_FALSE(socket_.receive(heard));
    EXPECT_EQ(socket_.state(), BusState::passive);
    EXPECT_EQ(socket_.counters().no_acks, 1U);
    put_error(CAN_ERR_BUSOFF);
    EXPECT_FALSE(socket_.receive(heard));
    EXPECT_EQ(socket_.state(), BusState::bus_off);
    EXPECT_EQ(socket_.counters().bus_offs, 1U);
    put_error(CAN_ERR_RESTARTED);
    EXPECT_FALSE(socket_.receive(heard));
    EXPECT_EQ(socket_.state(), BusState::active);
    EXPECT_EQ(socket_.counters().restarts, 1U);
    put_error(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW);
    put_error(CAN_ERR_LOSTARB);
    EXPECT_FALSE(socket_.receive(heard));
    EXPECT_EQ(socket_.counters().overflows, 1U);
    EXPECT_EQ(socket_.counters().lost_arbitrations, 1U);
    EXPECT_EQ(socket_.counters().errors, 6U);
    EXPECT_EQ(socket_.counters().received, 0U);
}

TEST_F(CanSocketTest, AFrameAfterBusOffMeansThatTheBusIsBack) {
    CanFrame heard;
    put_error(CAN_ERR_BUSOFF);
    can_frame raw{};
    raw.can_id = 0x701;
    put(&raw, sizeof raw);
    ASSERT_TRUE(socket_.receive(heard));
    EXPECT_EQ(socket_.state(), BusState::active);
}

TEST_F(CanSocketTest, SeesThatThePeerHasGone) {
    CanFrame frame;
    hang_up();
    EXPECT_FALSE(socket_.receive(frame));
    EXPECT_TRUE(socket_.closed());
    EXPECT_EQ(socket_.send(frame), CanSent::down);
}

TEST_F(CanSocketTest, MovesWithItsFile) {
    const int file = socket_.file();
    CanSocket other(std::move(socket_));
    EXPECT_EQ(other.file(), file);
    CanFrame frame;
    EXPECT_EQ(other.send(frame), CanSent::yes);
}

TEST(CanSocketOpen, SaysWhatIsMissing) {
    try {
        const CanSocket socket("can_not_here");
        FAIL();
    } catch (const std::system_error& error) {
        EXPECT_NE(std::string(error.what()).find("can_not_here"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace sc::socketcan
