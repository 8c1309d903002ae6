// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/drive.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

constexpr std::int64_t kMs = 1'000'000;

DriveFrame frame(std::uint16_t id, std::initializer_list<int> bytes) {
    DriveFrame out;
    out.id = id;
    for (const int byte : bytes) {
        out.data.at(out.size++) = static_cast<std::uint8_t>(byte);
    }
    return out;
}

/// A drive of node 1 spoken to by hand-written frames.
class SimDriveTest : public ::testing::Test {
protected:
    std::vector<DriveFrame> send(const DriveFrame& f) {
        drive.receive(f, now);
        return take();
    }
    std::vector<DriveFrame> take() {
        std::vector<DriveFrame> frames;
        drive.drain(frames);
        return frames;
    }
    std::vector<DriveFrame> wait(std::int64_t ns) {
        now += ns;
        drive.step_to(now);
        return take();
    }
    void write(std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::uint32_t value) {
        DriveFrame f = frame(0x601, {0x23 | ((4 - size) << 2), index & 0xFF, index >> 8, sub, 0, 0, 0, 0});
        for (std::size_t i = 0; i < 4; ++i) {
            f.data.at(4 + i) = static_cast<std::uint8_t>(value >> (8 * i));
        }
        const auto reply = send(f);
        ASSERT_EQ(reply.size(), 1U);
        ASSERT_EQ(reply[0].data[0], 0x60) << std::hex << index;
    }
    void map_pdos() {
        write(0x1600, 1, 4, 0x60400010);
        write(0x1600, 2, 4, 0x607A0020);
        write(0x1600, 0, 1, 2);
        write(0x1400, 2, 1, 1);
        write(0x1400, 1, 4, 0x201);
        write(0x1A00, 1, 4, 0x60410010);
        write(0x1A00, 2, 4, 0x60640020);
        write(0x1A00, 0, 1, 2);
        write(0x1800, 2, 1, 1);
        write(0x1800, 1, 4, 0x181);
        write(0x60C2, 1, 1, 2);
        write(0x6060, 0, 1, 8);
    }
    void start() {
        wait(30 * kMs);
        map_pdos();
        send(frame(0x000, {0x01, 0x01}));
    }
    /// RPDO and SYNC; the TPDO's statusword.
    int cycle(std::uint16_t word, std::int32_t target) {
        const auto t = static_cast<std::uint32_t>(target);
        send(frame(0x201, {word & 0xFF, word >> 8, static_cast<int>(t & 0xFF), static_cast<int>((t >> 8) & 0xFF),
                           static_cast<int>((t >> 16) & 0xFF), static_cast<int>(t >> 24)}));
        int status = -1;
        for (const DriveFrame& f : send(frame(0x080, {}))) {
            if (f.id == 0x181) {
                status = f.data[0] | (f.data[1] << 8);
            }
        }
        wait(2 * kMs);
        return status;
    }
    void enable() {
        for (const std::uint16_t word : {std::uint16_t{0x06}, std::uint16_t{0x07}, std::uint16_t{0x0F}}) {
            cycle(word, 0);
        }
    }

    static SimDriveOptions options() { return drive_options(reference_machine().axis[0], 2 * kMs, -0.1); }
    SimDrive drive{options()};
    std::int64_t now = 0;
};

TEST_F(SimDriveTest, LatencyLeavesTheServoItsShare) {
    EXPECT_NEAR(options().servo.lag_s, 2e-3, 1e-12);
    EXPECT_NEAR(drive_options(reference_machine().axis[0], 2 * kMs, 0.0, 500'000).servo.lag_s, 1.5e-3, 1e-12);
    EXPECT_THROW(static_cast<void>(drive_options(reference_machine().axis[0], 4 * kMs, 0.0)), std::invalid_argument);
}

TEST_F(SimDriveTest, BootsUpOnceAndIsSilentBefore) {
    EXPECT_TRUE(send(frame(0x601, {0x40, 0, 0x10, 0, 0, 0, 0, 0})).empty());
    const auto frames = wait(30 * kMs);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0], frame(0x701, {0x00}));
    EXPECT_TRUE(wait(100 * kMs).empty()) << "no heartbeat before 1017 is written";
}

TEST_F(SimDriveTest, HeartbeatCarriesTheNmtState) {
    wait(30 * kMs);
    write(0x1017, 0, 2, 20);
    const auto before = wait(41 * kMs);
    ASSERT_GE(before.size(), 2U);
    EXPECT_EQ(before.back(), frame(0x701, {0x7F}));
    send(frame(0x000, {0x01, 0x00}));
    EXPECT_EQ(wait(20 * kMs).back(), frame(0x701, {0x05}));
    send(frame(0x000, {0x02, 0x01}));
    EXPECT_EQ(wait(20 * kMs).back(), frame(0x701, {0x04}));
}

TEST_F(SimDriveTest, NmtOfAnotherNodeDoesNotMatter) {
    wait(30 * kMs);
    map_pdos();
    send(frame(0x000, {0x01, 0x02}));
    EXPECT_TRUE(send(frame(0x080, {})).empty()) << "still pre-operational";
    send(frame(0x000, {0x01, 0x01}));
    EXPECT_EQ(send(frame(0x080, {})).size(), 1U);
}

TEST_F(SimDriveTest, TpdoComesAtEverySecondSyncIfAskedFor) {
    wait(30 * kMs);
    map_pdos();
    write(0x1800, 2, 1, 2);
    send(frame(0x000, {0x01, 0x01}));
    std::size_t answers = 0;
    for (int i = 0; i < 10; ++i) {
        answers += send(frame(0x080, {})).size();
    }
    EXPECT_EQ(answers, 5U);
}

TEST_F(SimDriveTest, RpdoTakesEffectAtTheSync) {
    start();
    cycle(0x06, 0);
    cycle(0x07, 0);
    send(frame(0x201, {0x0F, 0, 0, 0, 0, 0}));
    EXPECT_EQ(drive.state(), DriveStates::State::switched_on);
    send(frame(0x080, {}));
    EXPECT_EQ(drive.state(), DriveStates::State::operation_enabled);
}

TEST_F(SimDriveTest, WithoutAPresetTheAxisJumps) {
    start();
    cycle(0x06, 0);
    cycle(0x07, 0);
    cycle(0x0F, 50);
    wait(20 * kMs);
    EXPECT_NEAR(drive.true_position(), -0.1 + 50e-6, 1e-6) << "this is what the master's preset prevents";
}

TEST_F(SimDriveTest, StatusShowsCspFollowing) {
    start();
    enable();
    EXPECT_EQ(cycle(0x0F, 0), 0x1237);
}

TEST_F(SimDriveTest, FollowingErrorEndsInFaultWithEmergency) {
    start();
    write(0x6065, 0, 4, 100);
    write(0x6066, 0, 2, 10);
    enable();
    drive.block(true);
    std::vector<DriveFrame> frames;
    for (int i = 1; i <= 20; ++i) {
        drive.receive(frame(0x201, {0x0F, 0, -20 * i & 0xFF, -20 * i >> 8 & 0xFF, 0xFF, 0xFF}), now);
        drive.receive(frame(0x080, {}), now);
        now += 2 * kMs;
        drive.step_to(now);
        drive.drain(frames);
    }
    EXPECT_EQ(drive.state(), DriveStates::State::fault);
    const auto emergency = std::ranges::find_if(frames, [](const DriveFrame& f) { return f.id == 0x081; });
    ASSERT_NE(emergency, frames.end());
    EXPECT_EQ(emergency->data[0] | (emergency->data[1] << 8), 0x8611);
    EXPECT_EQ(cycle(0x00, 0) & 0x4F, 0x08);
}

TEST_F(SimDriveTest, FaultResetSendsTheEndOfTheEmergency) {
    start();
    drive.raise_fault(0x5113);
    EXPECT_EQ(take().back().data[0], 0x13);
    cycle(0x00, 0);
    send(frame(0x201, {0x80, 0, 0, 0, 0, 0}));
    const auto frames = send(frame(0x080, {}));
    EXPECT_TRUE(std::ranges::any_of(frames, [](const DriveFrame& f) { return f.id == 0x081 && f.data[0] == 0; }));
    EXPECT_EQ(drive.state(), DriveStates::State::switch_on_disabled);
}

TEST_F(SimDriveTest, LeavingOperationalWithPowerIsAQuickStop) {
    start();
    enable();
    ASSERT_EQ(drive.state(), DriveStates::State::operation_enabled);
    send(frame(0x000, {0x80, 0x01}));
    wait(100 * kMs);
    EXPECT_EQ(drive.state(), DriveStates::State::switch_on_disabled);
}

TEST_F(SimDriveTest, ResetForgetsEverythingButThePlace) {
    start();
    enable();
    send(frame(0x000, {0x81, 0x01}));
    EXPECT_EQ(drive.state(), DriveStates::State::switch_on_disabled);
    const auto frames = wait(30 * kMs);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0], frame(0x701, {0x00}));
    EXPECT_NEAR(drive.true_position(), -0.1, 1e-9);
    EXPECT_TRUE(send(frame(0x080, {})).empty());
}

TEST_F(SimDriveTest, PlaceBetweenTwoStepsIsSmooth) {
    start();
    enable();
    for (int i = 1; i <= 50; ++i) {
        cycle(0x0F, -200 * i);
    }
    const std::int64_t from = now;
    const double place = drive.true_position();
    drive.step_to(from + 100'000);
    EXPECT_NEAR(drive.true_position_at(from), place, 1e-15);
    EXPECT_EQ(drive.true_position_at(from + 100'000), drive.true_position());
    const double middle = drive.true_position_at(from + 50'000);
    EXPECT_NEAR(middle, 0.5 * (place + drive.true_position()), 1e-8);
    EXPECT_EQ(drive.true_position_at(from - kMs), place) << "clamped";
}

}  // namespace
}  // namespace sc::sim
