// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/drive_node.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include <gtest/gtest.h>

namespace sc::drives {
namespace {

constexpr std::uint16_t kEnabledWord = 0x1237;  ///< Operation enabled, voltage, remote, bit 12
constexpr std::uint16_t kDisabledWord = 0x0250;
constexpr std::uint16_t kReadyWord = 0x0231;
constexpr std::uint16_t kSwitchedOnWord = 0x0233;
constexpr std::uint16_t kFaultWord = 0x0218;

/// One node and a drive played by the test: SDOs are answered from a table, statuswords are what the test says.
class DriveNodeTest : public ::testing::Test {
protected:
    void SetUp() override {
        objects[{0x6502, 0}] = 0xA0;
        objects[{0x6061, 0}] = 8;
    }

    void answer(const DriveFrame& asked) {
        const auto index = static_cast<std::uint16_t>(asked.data[1] | (asked.data[2] << 8U));
        const std::pair key{index, asked.data[3]};
        DriveFrame reply = asked;
        reply.id = 0x581;
        if (key == refused) {
            reply.data[0] = 0x80;
        } else if (asked.data[0] == 0x40) {
            const auto value = std::bit_cast<std::array<std::uint8_t, 4>>(objects[key]);
            reply.data[0] = 0x43;
            std::ranges::copy(value, reply.data.begin() + 4);
        } else {
            std::array<std::uint8_t, 4> bytes{};
            std::ranges::copy(std::span(asked.data).subspan(4), bytes.begin());
            objects[key] = std::bit_cast<std::uint32_t>(bytes);
            reply.data[0] = 0x60;
            mode_asked = index == 0x6060 ? asked.data[4] : mode_asked;
        }
        node.receive(reply, tick);
    }

    void heartbeat(std::uint8_t state) { node.receive(canopen::heartbeat(1, canopen::NmtState{state}), tick); }
    void status(std::uint16_t word, std::int32_t counts) {
        DriveFrame frame;
        frame.id = 0x181;
        frame.size = 6;
        const auto bytes = std::bit_cast<std::array<std::uint8_t, 4>>(counts);
        frame.data = {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8U)};
        std::ranges::copy(bytes, frame.data.begin() + 2);
        node.receive(frame, tick);
    }

    /// One cycle: status and heartbeat in, RPDO out, and one SDO between.
    void cycle(std::uint16_t word, std::int32_t counts) {
        heartbeat(5);
        status(word, counts);
        step(true);
        step(false);
    }
    void step(bool on_cycle) {
        node.update(request, tick, on_cycle);
        if (on_cycle) {
            rpdo = node.rpdo_frame();
        } else if (const auto frame = node.sdo_frame(tick)) {
            answer(*frame);
        }
        if (const auto frame = node.nmt_frame(0)) {
            nmt = frame->data[0];
        }
        ++tick;
    }
    [[nodiscard]] int controlword() const { return rpdo ? rpdo->data[0] | (rpdo->data[1] << 8) : -1; }
    [[nodiscard]] std::int32_t target() const {
        std::array<std::uint8_t, 4> bytes{};
        std::ranges::copy(std::span(rpdo->data).subspan(2, 4), bytes.begin());
        return std::bit_cast<std::int32_t>(bytes);
    }
    void boot() {
        step(true);
        heartbeat(0);
        for (int i = 0; i < 300 && nmt != 0x01; ++i) {
            step(i % 2 == 0);
        }
        cycle(kDisabledWord, 100);
    }
    void enable() {
        request.power = true;
        for (const std::uint16_t word : {kDisabledWord, kReadyWord, kSwitchedOnWord, kEnabledWord}) {
            cycle(word, 100);
        }
    }

    DriveNode node{reference_machine(), 0};
    NodeRequest request{};
    std::optional<DriveFrame> rpdo;
    std::map<std::pair<std::uint16_t, std::uint8_t>, std::uint32_t> objects;
    std::pair<std::uint16_t, std::uint8_t> refused{};
    int mode_asked = 0;
    int nmt = -1;
    std::int64_t tick = 0;
};

TEST_F(DriveNodeTest, ResetsSetsUpAndStartsTheNode) {
    step(true);
    EXPECT_EQ(nmt, 0x81);
    EXPECT_FALSE(node.present());
    boot();
    EXPECT_EQ(nmt, 0x01);
    EXPECT_TRUE(node.present());
    EXPECT_EQ((objects[{0x1600, 1}]), 0x6040'0010U);
    EXPECT_EQ(mode_asked, 8);
}

TEST_F(DriveNodeTest, SendsNoTargetsBeforeItIsOperational) {
    step(true);
    EXPECT_FALSE(rpdo);
    heartbeat(0);
    step(true);
    EXPECT_FALSE(rpdo);
}

TEST_F(DriveNodeTest, ResetsAgainWhenNoBootUpComes) {
    int resets = 0;
    for (int i = 0; i < 2500; ++i) {
        nmt = -1;
        step(true);
        resets += nmt == 0x81 ? 1 : 0;
    }
    EXPECT_EQ(resets, 3);
}

TEST_F(DriveNodeTest, AbortOfANeededObjectKeepsTheDriveAbsent) {
    refused = {0x6099, 1};
    boot();
    EXPECT_FALSE(node.present());
    EXPECT_EQ(nmt, 0x81);
}

TEST_F(DriveNodeTest, AbortOfAnOptionalObjectDoesNotMatter) {
    refused = {0x6065, 0};
    boot();
    EXPECT_TRUE(node.present());
}

TEST_F(DriveNodeTest, DriveWithoutCspIsNotTaken) {
    objects[{0x6502, 0}] = 0x21;
    boot();
    EXPECT_FALSE(node.present());
}

TEST_F(DriveNodeTest, WaitsForTheConfirmedStatusBeforeTheNextTransition) {
    boot();
    request.power = true;
    cycle(kDisabledWord, 100);
    EXPECT_EQ(controlword(), 0x06);
    cycle(kDisabledWord, 100);
    EXPECT_EQ(controlword(), 0x06) << "not confirmed";
    cycle(kReadyWord, 100);
    EXPECT_EQ(controlword(), 0x07);
    cycle(kSwitchedOnWord, 100);
    EXPECT_EQ(controlword(), 0x0F);
    EXPECT_FALSE(node.enabled());
    cycle(kEnabledWord, 100);
    EXPECT_TRUE(node.enabled());
}

TEST_F(DriveNodeTest, PresetsTheTargetToTheActualPosition) {
    boot();
    request.power = true;
    request.target = 777'000'000'000;
    cycle(kSwitchedOnWord, 4321);
    EXPECT_EQ(controlword(), 0x0F);
    EXPECT_EQ(target(), 4321);
    cycle(kEnabledWord, 4320);
    EXPECT_EQ(target(), 4321) << "held until the caller follows";
    EXPECT_FALSE(node.follows());
}

TEST_F(DriveNodeTest, UsesTheTargetOneTickAfterSayingSo) {
    boot();
    enable();
    request.may_follow = true;
    request.target = 250'499'999;
    cycle(kEnabledWord, 100);
    EXPECT_TRUE(node.follows());
    EXPECT_EQ(target(), 100);
    cycle(kEnabledWord, 100);
    EXPECT_EQ(target(), 250) << "rounded to counts here";
    request.target = 250'500'000;
    cycle(kEnabledWord, 100);
    EXPECT_EQ(target(), 251);
    request.target = -250'500'000;
    cycle(kEnabledWord, 100);
    EXPECT_EQ(target(), -251);
    request.target = INT64_MAX;
    cycle(kEnabledWord, 100);
    EXPECT_EQ(target(), INT32_MAX);
}

TEST_F(DriveNodeTest, EnabledNeedsBit12InCsp) {
    boot();
    enable();
    EXPECT_TRUE(node.enabled());
    cycle(0x0237, 100);
    EXPECT_FALSE(node.enabled()) << "Operation enabled, but the drive does not follow 607A";
}

TEST_F(DriveNodeTest, FaultResetNeedsAnEdge) {
    boot();
    enable();
    cycle(kFaultWord, 100);
    EXPECT_TRUE(node.fault());
    EXPECT_EQ(controlword(), 0x00);
    cycle(kFaultWord, 100);
    EXPECT_EQ(controlword(), 0x00) << "not without being asked";
    request.reset = true;
    cycle(kFaultWord, 100);
    request.reset = false;
    EXPECT_EQ(controlword(), 0x00) << "zero first";
    cycle(kFaultWord, 100);
    EXPECT_EQ(controlword(), 0x80);
    cycle(kDisabledWord, 100);
    EXPECT_FALSE(node.fault());
    EXPECT_EQ(controlword() & 0x80, 0);
}

TEST_F(DriveNodeTest, FaultResetIsGivenUp) {
    boot();
    cycle(kFaultWord, 100);
    request.reset = true;
    cycle(kFaultWord, 100);
    request.reset = false;
    for (int i = 0; i < 50; ++i) {
        cycle(kFaultWord, 100);
    }
    EXPECT_EQ(controlword(), 0x00);
}

TEST_F(DriveNodeTest, QuickStopUntilTheDriveIsDisabledByItself) {
    boot();
    enable();
    request.quick_stop = true;
    cycle(kEnabledWord, 100);
    EXPECT_EQ(controlword(), 0x02);
    cycle(0x0217, 100);
    EXPECT_EQ(controlword(), 0x02);
    EXPECT_FALSE(node.enabled());
    cycle(kDisabledWord, 100);
    EXPECT_EQ(controlword(), 0x00) << "no power while the stop is asked for";
}

TEST_F(DriveNodeTest, ModeIsChangedOnlyWhenTheDisplayShowsIt) {
    boot();
    enable();
    request.home = true;
    for (int i = 0; i < 10; ++i) {
        cycle(kEnabledWord, 100);
    }
    EXPECT_EQ(mode_asked, 6);
    EXPECT_EQ(controlword(), 0x0F) << "6061 still shows CSP";
    objects[{0x6061, 0}] = 6;
    for (int i = 0; i < 3; ++i) {
        cycle(0x0237, 100);
    }
    EXPECT_EQ(controlword(), 0x1F);
    EXPECT_TRUE(node.enabled()) << "bit 12 means something else in homing";
}

TEST_F(DriveNodeTest, HomingEndsInCspWithAPresetTarget) {
    boot();
    enable();
    objects[{0x6061, 0}] = 6;
    request.home = true;
    for (int i = 0; i < 10; ++i) {
        cycle(0x0237, 100);
    }
    ASSERT_EQ(controlword(), 0x1F);
    objects[{0x6061, 0}] = 8;
    for (int i = 0; i < 3; ++i) {
        cycle(0x1637, -7);
    }
    EXPECT_EQ(controlword(), 0x0F);
    EXPECT_EQ(mode_asked, 8);
    for (int i = 0; i < 6; ++i) {
        cycle(kEnabledWord, -7);
    }
    EXPECT_TRUE(node.homing().done());
    EXPECT_TRUE(node.homing().homed());
    EXPECT_EQ(target(), -7);
    EXPECT_FALSE(node.follows()) << "not while the homing is still asked for";
    request.home = false;
    request.may_follow = true;
    cycle(kEnabledWord, -7);
    EXPECT_TRUE(node.follows());
}

TEST_F(DriveNodeTest, OldHomingBitsAtTheStartDoNotCount) {
    boot();
    enable();
    objects[{0x6061, 0}] = 6;
    request.home = true;
    for (int i = 0; i < 3; ++i) {
        cycle(0x1637, 100);
    }
    EXPECT_FALSE(node.homing().homed());
    for (int i = 0; i < 3 && controlword() != 0x1F; ++i) {
        cycle(0x1637, 100);
    }
    EXPECT_EQ(controlword(), 0x1F);
    for (int i = 0; i < 2; ++i) {
        cycle(0x1637, 100);
    }
    for (int i = 0; i < 30; ++i) {
        cycle(0x0237, 100);
    }
    EXPECT_EQ(controlword(), 0x1F) << "still running";
    EXPECT_EQ(mode_asked, 6);
}

TEST_F(DriveNodeTest, LateStatusOfHomingModeDoesNotLookLikeALostCsp) {
    boot();
    enable();
    objects[{0x6061, 0}] = 6;
    request.home = true;
    for (int i = 0; i < 10; ++i) {
        cycle(0x0237, 100);
    }
    objects[{0x6061, 0}] = 8;
    request.home = false;
    int cycles = 0;
    while (mode_asked != 8 && cycles++ < 50) {
        cycle(0x0637, 100);
    }
    ASSERT_EQ(mode_asked, 8);
    for (int i = 0; i < 3; ++i) {
        cycle(0x0637, 100);
        EXPECT_TRUE(node.enabled()) << "6061 shows CSP, the status is older";
    }
    for (int i = 0; i < 10; ++i) {
        cycle(kEnabledWord, 100);
        EXPECT_TRUE(node.enabled());
    }
    EXPECT_FALSE(node.homing().active());
}

TEST_F(DriveNodeTest, DriveThatStaysInHomingModeIsSetUpAgain) {
    boot();
    enable();
    objects[{0x6061, 0}] = 6;
    request.home = true;
    for (int i = 0; i < 10; ++i) {
        cycle(0x0237, 100);
    }
    for (int i = 0; i < 200; ++i) {
        cycle(0x1637, 100);
    }
    EXPECT_FALSE(node.present());
}

TEST_F(DriveNodeTest, EmergencyIsKeptWhenTheErrorIsGone) {
    boot();
    DriveFrame emergency;
    emergency.id = 0x081;
    emergency.size = 8;
    emergency.data = {0x11, 0x86};
    node.receive(emergency, tick);
    EXPECT_EQ(node.error_code(), 0x8611);
    emergency.data = {};
    node.receive(emergency, tick);
    EXPECT_EQ(node.error_code(), 0x8611);
}

TEST_F(DriveNodeTest, AFaultIsToldByTheFrameItself) {
    boot();
    DriveFrame emergency;
    emergency.id = 0x081;
    emergency.size = 8;
    emergency.data = {0x11, 0x86};
    EXPECT_TRUE(node.tells_fault(emergency));
    emergency.id = 0x082;  // another drive's
    EXPECT_FALSE(node.tells_fault(emergency));
    emergency.id = 0x081;
    emergency.data = {};  // the error is gone
    EXPECT_FALSE(node.tells_fault(emergency));
    DriveFrame status;
    status.id = 0x181;
    status.size = 6;
    for (const unsigned word : {0x0008U, 0x000FU, 0x1218U, 0x0037U, 0x0250U, 0x0031U, 0x0007U}) {
        status.data = {static_cast<std::uint8_t>(word & 0xFFU), static_cast<std::uint8_t>(word >> 8U)};
        const bool fault = (word & 0x4FU) == 0x08U || (word & 0x4FU) == 0x0FU;
        EXPECT_EQ(node.tells_fault(status), fault) << word;
    }
    EXPECT_FALSE(node.fault()) << "looking at frames must change nothing";
}

TEST_F(DriveNodeTest, SilentHeartbeatLosesTheDrive) {
    boot();
    // The last heartbeat came two ticks ago.
    for (int i = 2; i <= 101; ++i) {
        ASSERT_TRUE(node.present()) << i;
        status(kDisabledWord, 0);
        step(i % 2 == 0);
    }
    EXPECT_FALSE(node.present());
}

TEST_F(DriveNodeTest, HeartbeatOfAnotherStateDoesNotCount) {
    boot();
    for (int i = 0; i < 110; ++i) {
        heartbeat(0x7F);
        status(kDisabledWord, 0);
        step(i % 2 == 0);
    }
    EXPECT_FALSE(node.present());
}

TEST_F(DriveNodeTest, MissingStatusLosesTheDriveInFiveCycles) {
    boot();
    int ticks = 0;
    while (node.present() && ticks < 100) {
        heartbeat(5);
        step(ticks % 2 == 0);
        ++ticks;
    }
    EXPECT_GE(ticks, 8);
    EXPECT_LE(ticks, 12);
}

TEST_F(DriveNodeTest, BootUpInOperationLosesHomeAndPower) {
    boot();
    enable();
    ASSERT_TRUE(node.enabled());
    heartbeat(0);
    EXPECT_FALSE(node.present());
    EXPECT_FALSE(node.enabled());
    EXPECT_FALSE(node.homing().homed());
}

TEST_F(DriveNodeTest, MalformedFramesAreIgnored) {
    boot();
    enable();
    for (const std::uint16_t id : std::array<std::uint16_t, 4>{0x181, 0x081, 0x581, 0x701}) {
        for (std::uint8_t size = 0; size <= 8; ++size) {
            DriveFrame frame;
            frame.id = id;
            frame.size = size;
            const bool meaningful = (id == 0x181 && size == 6) || (id == 0x701 && size == 1);
            if (!meaningful) {
                node.receive(frame, tick);
            }
        }
    }
    EXPECT_TRUE(node.enabled());
    EXPECT_EQ(node.error_code(), 0);
}

}  // namespace
}  // namespace sc::drives
