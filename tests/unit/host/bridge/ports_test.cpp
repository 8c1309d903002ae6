// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/ports.hpp"

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>

namespace sc::host {
namespace {

namespace fs = std::filesystem;

/// A PC of files.
class PortsTest : public testing::Test {
protected:
    PortsTest() {
        std::string pattern = (fs::temp_directory_path() / "scribecell-XXXXXX").string();
        EXPECT_NE(::mkdtemp(pattern.data()), nullptr);
        root_ = pattern;
        sources_.root = root_;
        sources_.may_use = [this](const std::string&) { return may_use_; };
        sources_.can_details = [this](unsigned index) {
            asked_ = index;
            return std::optional(details_);
        };
    }
    ~PortsTest() override { fs::remove_all(root_); }
    void file(const std::string& path, const std::string& text) const {
        fs::create_directories((root_ / path).parent_path());
        std::ofstream(root_ / path) << text << '\n';
    }
    void link(const std::string& path, const std::string& to) const {
        fs::create_directories((root_ / path).parent_path());
        fs::create_symlink(to, root_ / path);
    }
    void can(const std::string& name, const char* flags, const char* mtu) const {
        file("sys/class/net/" + name + "/type", "280");
        file("sys/class/net/" + name + "/flags", flags);
        file("sys/class/net/" + name + "/mtu", mtu);
        file("sys/class/net/" + name + "/ifindex", "5");
        file("sys/class/net/" + name + "/tx_queue_len", "10");
    }
    fs::path root_;
    PortSources sources_;
    CanDetails details_{.kind = "can",
                        .bitrate = 1'000'000,
                        .data_bitrate = {},
                        .state = "error-active",
                        .restart_ms = 100,
                        .queue_length = 128};
    unsigned asked_ = 0;
    bool may_use_ = true;
};

TEST_F(PortsTest, ABarePcHasNothing) {
    sources_.kernel_has_can = false;
    const Ports ports = find_ports(sources_);
    EXPECT_TRUE(ports.can.empty() && ports.serial.empty() && ports.hid.empty() && ports.gpio.empty());
    ASSERT_EQ(ports.missing.size(), 1U);
}

TEST_F(PortsTest, ACanInterfaceThatIsWellLacksNothing) {
    can("can0", "0x40081", "72");
    file("sys/class/net/eth0/type", "1");
    const Ports ports = find_ports(sources_);
    ASSERT_EQ(ports.can.size(), 1U);
    EXPECT_EQ(asked_, 5U);
    EXPECT_EQ(ports.can[0].name, "can0");
    EXPECT_TRUE(ports.can[0].up && ports.can[0].fd);
    EXPECT_EQ(ports.can[0].details.bitrate, 1'000'000U);
    EXPECT_TRUE(ports.can[0].missing.empty()) << ports.can[0].missing[0];
}

TEST_F(PortsTest, SaysWhatACanInterfaceLacks) {
    const auto first = [this](const char* flags) {
        can("can1", flags, "16");
        const Ports ports = find_ports(sources_);
        return ports.can.at(0).missing.empty() ? std::string() : ports.can[0].missing[0];
    };
    EXPECT_NE(first("0x40080").find("down"), std::string::npos);
    details_.state = "bus-off";
    EXPECT_NE(first("0x40081").find("type can restart"), std::string::npos);
    details_.state = "error-passive";
    EXPECT_NE(first("0x40081").find("error-passive"), std::string::npos);
    details_.state = "error-active";
    details_.restart_ms = 0;
    EXPECT_NE(first("0x40081").find("restart-ms"), std::string::npos);
    details_.restart_ms = 100;
    details_.queue_length = 0;  // the file says 10
    EXPECT_NE(first("0x40081").find("txqueuelen 128"), std::string::npos);
}

TEST_F(PortsTest, SerialPortsHaveTheirLastingNamesAndAbsentOnesAreLeftOut) {
    link("sys/class/tty/ttyUSB0/device/driver", "../../../bus/usb-serial/drivers/ftdi_sio");
    fs::create_directories(root_ / "sys/bus/usb-serial/drivers/ftdi_sio");
    fs::remove(root_ / "sys/class/tty/ttyUSB0/device/driver");
    link("sys/class/tty/ttyUSB0/device/driver", (root_ / "sys/bus/usb-serial/drivers/ftdi_sio").string());
    link("sys/class/tty/ttyS0/device/driver", (root_ / "sys/bus/usb-serial/drivers/ftdi_sio").string());
    file("sys/class/tty/ttyS0/type", "0");
    file("sys/class/tty/console/active", "tty0");
    link("dev/serial/by-id/usb-FTDI_A1-if00-port0", "../../ttyUSB0");
    may_use_ = false;
    const Ports ports = find_ports(sources_);
    ASSERT_EQ(ports.serial.size(), 1U);
    EXPECT_EQ(ports.serial[0].device, (root_ / "dev/ttyUSB0").string());
    EXPECT_EQ(ports.serial[0].driver, "ftdi_sio");
    EXPECT_NE(ports.serial[0].by_id.find("usb-FTDI_A1"), std::string::npos);
    ASSERT_EQ(ports.serial[0].missing.size(), 1U);
    EXPECT_NE(ports.serial[0].missing[0].find("dialout"), std::string::npos);
}

TEST_F(PortsTest, ThePendantIsKnownByItsNumbers) {
    file("sys/class/hidraw/hidraw0/device/uevent", "HID_ID=0003:000010CE:0000EB93\nHID_NAME=KTURT.LTD");
    file("sys/class/hidraw/hidraw1/device/uevent", "HID_ID=0003:0000046D:0000C31C\nHID_NAME=Keyboard");
    may_use_ = false;
    const Ports ports = find_ports(sources_);
    ASSERT_EQ(ports.hid.size(), 2U);
    EXPECT_TRUE(ports.hid[0].pendant);
    EXPECT_EQ(ports.hid[0].name, "KTURT.LTD");
    EXPECT_EQ(ports.hid[0].missing.size(), 1U);
    EXPECT_FALSE(ports.hid[1].pendant);
    EXPECT_TRUE(ports.hid[1].missing.empty());
}

TEST_F(PortsTest, GpioChipsAreListed) {
    file("dev/gpiochip0", "");
    file("dev/null0", "");
    const Ports ports = find_ports(sources_);
    ASSERT_EQ(ports.gpio.size(), 1U);
    EXPECT_TRUE(ports.gpio[0].missing.empty());
}

/// Attributes as the kernel lays them out.
std::vector<std::uint8_t> attribute(unsigned short type, const void* payload, std::size_t size) {
    rtattr head{};
    head.rta_len = static_cast<unsigned short>(sizeof head + size);
    head.rta_type = type;
    std::vector<std::uint8_t> bytes(sizeof head + (size + 3) / 4 * 4);
    std::memcpy(bytes.data(), &head, sizeof head);
    std::memcpy(bytes.data() + sizeof head, payload, size);
    return bytes;
}

std::vector<std::uint8_t> joined(const std::vector<std::vector<std::uint8_t>>& parts) {
    std::vector<std::uint8_t> all;
    for (const auto& part : parts) {
        all.insert(all.end(), part.begin(), part.end());
    }
    return all;
}

TEST(CanNetlink, ReadsRateStateAndQueueFromTheKernelsAnswer) {
    can_bittiming timing{};
    timing.bitrate = 500'000;
    can_bittiming data_timing{};
    data_timing.bitrate = 2'000'000;
    const std::uint32_t state = 3;
    const std::uint32_t restart = 100;
    const std::uint32_t queue = 10;
    const auto data = joined({attribute(IFLA_CAN_BITTIMING, &timing, sizeof timing),
                              attribute(IFLA_CAN_DATA_BITTIMING, &data_timing, sizeof data_timing),
                              attribute(IFLA_CAN_STATE, &state, sizeof state),
                              attribute(IFLA_CAN_RESTART_MS, &restart, sizeof restart)});
    const auto info = joined(
        {attribute(IFLA_INFO_KIND, "can", 4), attribute(IFLA_INFO_DATA | NLA_F_NESTED, data.data(), data.size())});
    const auto attributes =
        joined({attribute(IFLA_TXQLEN, &queue, sizeof queue), attribute(IFLA_LINKINFO, info.data(), info.size())});
    nlmsghdr head{};
    head.nlmsg_type = RTM_NEWLINK;
    head.nlmsg_len = static_cast<std::uint32_t>(sizeof(nlmsghdr) + sizeof(ifinfomsg) + attributes.size());
    std::vector<std::uint8_t> message(sizeof(nlmsghdr) + sizeof(ifinfomsg));
    std::memcpy(message.data(), &head, sizeof head);
    message.insert(message.end(), attributes.begin(), attributes.end());

    const auto details = parse_can_link(message);
    ASSERT_TRUE(details);
    EXPECT_EQ(details->kind, "can");
    EXPECT_EQ(details->bitrate, 500'000U);
    EXPECT_EQ(details->data_bitrate, 2'000'000U);
    EXPECT_EQ(details->state, "bus-off");
    EXPECT_EQ(details->restart_ms, 100U);
    EXPECT_EQ(details->queue_length, 10U);
    for (std::size_t size = 0; size < message.size(); ++size) {
        EXPECT_FALSE(parse_can_link(std::span(message).first(size))) << size;
    }
    message[sizeof(nlmsghdr) + sizeof(ifinfomsg)] = 1;  // an attribute shorter than its head
    EXPECT_EQ(parse_can_link(message)->kind, "");
}

}  // namespace
}  // namespace sc::host
