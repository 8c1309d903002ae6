// SPDX-License-Identifier: Apache-2.0
#include "boards/event_device/event_packets.hpp"

#include <memory>
#include <vector>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "boards/event_device/event_link.hpp"

namespace sc::event_device {
namespace {

TEST(EventPackets, ABeginningCarriesTheMachine) {
    std::vector<std::uint8_t> bytes(kBeginSize);
    MachineConfig machine = reference_machine();
    machine.laser.warning_ns = 123;
    ASSERT_EQ(put_begin(machine, bytes), kBeginSize);
    EXPECT_EQ(kind_of(bytes), Packet::begin);
    MachineConfig got;
    ASSERT_TRUE(get_begin(bytes, got));
    EXPECT_EQ(got.laser.warning_ns, 123);
    EXPECT_FALSE(get_begin(std::span(bytes).first(kBeginSize - 1), got));
    bytes[1] = 99;  // another version
    EXPECT_FALSE(get_begin(bytes, got));
}

TEST(EventPackets, AWindowComesBackAsItWas) {
    const auto out = std::make_unique<ServoOutputs>();
    out->laser[0] = {.t0_ns = 5'000'123, .period_ns256 = 256'000, .change_ns256 = -3, .count = 20, .power = 77};
    out->laser_size = 1;
    out->gate_allowed = true;
    out->set_point = {1, -2, 3, -4};
    out->state = 9;
    std::vector<std::uint8_t> bytes(kPacketCapacity);
    bytes.resize(put_window(41, *out, bytes));
    const auto got = std::make_unique<ServoOutputs>();
    std::int64_t tick = 0;
    ASSERT_TRUE(get_window(bytes, tick, *got));
    EXPECT_EQ(tick, 41);
    EXPECT_EQ(got->laser[0].t0_ns, 5'000'123);
    EXPECT_EQ(got->laser[0].change_ns256, -3);
    EXPECT_EQ(got->set_point, out->set_point);
    EXPECT_TRUE(got->gate_allowed);
    bytes.pop_back();
    EXPECT_FALSE(get_window(bytes, tick, *got));
}

TEST(EventPackets, StatusAndVetoAndWhatIsNone) {
    Status status;
    status.tick = 7;
    status.lines.laser_ready = status.lines.shutter_open = true;
    status.lines.source_status = 5;
    status.source[0] = 0x55;
    status.source_size = 1;
    std::vector<std::uint8_t> bytes(kStatusCapacity);
    bytes.resize(put_status(status, bytes));
    Status got;
    ASSERT_TRUE(get_status(bytes, got));
    EXPECT_EQ(got.tick, 7);
    EXPECT_EQ(got.lines, status.lines);
    EXPECT_EQ(got.source_size, 1U);
    EXPECT_EQ(got.source[0], 0x55);
    bytes.push_back(0);
    EXPECT_FALSE(get_status(bytes, got));
    std::vector<std::uint8_t> veto(2);
    ASSERT_EQ(put_veto(3, veto), 2U);
    std::uint8_t causes = 0;
    EXPECT_TRUE(get_veto(veto, causes));
    EXPECT_EQ(causes, 3);
    EXPECT_FALSE(get_veto(bytes, causes));
    EXPECT_FALSE(kind_of({}));
    EXPECT_FALSE(kind_of(std::vector<std::uint8_t>{200}));
}

class EventLinkTest : public testing::Test {
protected:
    EventLinkTest() {
        std::array<int, 2> files{};
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, files.data()), 0);
        device_ = files[1];
        link_ = std::make_unique<EventLink>(files[0], reference_machine());
    }
    ~EventLinkTest() override { hang_up(); }
    void hang_up() {
        if (device_ >= 0) {
            ::close(device_);
            device_ = -1;
        }
    }
    int device_ = -1;
    std::unique_ptr<EventLink> link_;
    std::unique_ptr<ServoOutputs> out_ = std::make_unique<ServoOutputs>();
};

TEST_F(EventLinkTest, ADeviceThatGoesIsLostForGood) {
    Status status;
    EXPECT_FALSE(link_->receive(status));
    EXPECT_FALSE(link_->lost());
    hang_up();
    EXPECT_FALSE(link_->receive(status));
    EXPECT_TRUE(link_->lost());
    link_->send(0, *out_);
    EXPECT_EQ(link_->counters().windows, 0U);
}

TEST_F(EventLinkTest, ADeviceThatDoesNotTakeItsWindowsIsLost) {
    std::int64_t tick = 0;
    while (!link_->lost() && tick < 100'000) {
        link_->send(tick, *out_);
        ++tick;
    }
    EXPECT_TRUE(link_->lost());
    EXPECT_EQ(link_->counters().full, 1U);
    // It sees its controller go, after what it had.
    std::vector<std::uint8_t> packet(kPacketCapacity);
    while (::recv(device_, packet.data(), packet.size(), 0) > 0) {
    }
    EXPECT_EQ(::recv(device_, packet.data(), packet.size(), 0), 0);
}

TEST_F(EventLinkTest, TheNewestStatusCountsAndNoByteOfTheSourceIsLost) {
    for (std::uint8_t i = 0; i < 3; ++i) {
        Status status;
        status.tick = i;
        status.source[0] = i;
        status.source_size = 1;
        std::array<std::uint8_t, kStatusCapacity> bytes{};
        ASSERT_GT(::send(device_, bytes.data(), put_status(status, bytes), 0), 0);
    }
    Status got;
    ASSERT_TRUE(link_->receive(got));
    EXPECT_EQ(got.tick, 2);
    ASSERT_EQ(got.source_size, 3U);
    EXPECT_EQ(got.source[1], 1);
}

}  // namespace
}  // namespace sc::event_device
