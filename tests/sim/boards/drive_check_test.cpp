// SPDX-License-Identifier: Apache-2.0
// The simulated drive against the list of what a drive must do.
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <iterator>
#include <thread>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include "boards/drive_check/cases.hpp"
#include "boards/drive_process/drive_process.hpp"
#include "boards/sim/plant/drive.hpp"
#include "shared/machine/machine.hpp"

namespace sc::drive_check {
namespace {

constexpr std::int64_t kCycleNs = 2'000'000;

sim::SimDriveOptions options_of(const std::string& quirks = "") {
    sim::SimDriveOptions options = sim::drive_options(reference_machine().axis[0], kCycleNs, -0.012);
    options.quirks = sim::drive_quirks(quirks);
    // Near enough for a homing to take a second.
    options.negative_limit = -0.020;
    options.positive_limit = 0.006;
    return options;
}

class SimPort final : public DrivePort {
public:
    explicit SimPort(const sim::SimDriveOptions& options) : drive_(options) {}
    void send(const Frame& frame) override {
        DriveFrame raw;
        raw.id = static_cast<std::uint16_t>(frame.id);
        raw.size = static_cast<std::uint8_t>(frame.data.size());
        std::ranges::copy(frame.data, raw.data.begin());
        drive_.receive(raw, t_ns_);
    }
    std::vector<Frame> cycle() override {
        send({0x080, {}});
        t_ns_ += kCycleNs;
        drive_.step_to(t_ns_);
        return answers();
    }
    std::vector<Frame> answers() override {
        std::vector<DriveFrame> sent;
        drive_.drain(sent);
        std::vector<Frame> frames;
        for (const DriveFrame& raw : sent) {
            frames.push_back({raw.id, {raw.data.begin(), raw.data.begin() + raw.size}});
        }
        return frames;
    }
    [[nodiscard]] double cycle_ms() const override { return 2.0; }

private:
    sim::SimDrive drive_;
    std::int64_t t_ns_ = 0;
};

struct Tally {
    int passed = 0;
    int left_out = 0;
    std::vector<std::string> failed;
};
Tally run_all(DriveClient& drive, bool print) {
    Tally tally;
    for (const Case& one : all_cases()) {
        const Result result = one.run(drive);
        if (result.verdict == Verdict::passed) {
            ++tally.passed;
        } else if (result.verdict == Verdict::left_out) {
            ++tally.left_out;
        } else {
            tally.failed.push_back(one.group + ": " + one.name + ": " + result.text);
        }
        if (print) {
            std::printf("%-14s %-52s %s\n", one.group.c_str(), one.name.c_str(),
                        result.verdict == Verdict::passed ? "passed" : result.text.c_str());
        }
    }
    return tally;
}

std::string list_of(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) {
        text += line + '\n';
    }
    return text;
}

TEST(DriveCheck, TheSimulatedDrivePassesEveryCase) {
    SimPort port(options_of());
    DriveClient drive(port, 1);
    const Tally tally = run_all(drive, true);
    EXPECT_TRUE(tally.failed.empty()) << list_of(tally.failed);
    EXPECT_EQ(tally.left_out, 0);
    EXPECT_GE(tally.passed, 70);
}

TEST(DriveCheck, QuirksLeaveItADrive) {
    for (const char* const quirks : {"no-6007", "event-driven,bit-30", "infranor", "no-period", "lenze-9400"}) {
        SimPort port(options_of(quirks));
        DriveClient drive(port, 1);
        const Tally tally = run_all(drive, false);
        EXPECT_TRUE(tally.failed.empty()) << quirks << ":\n" << list_of(tally.failed);
    }
}

TEST(DriveCheck, ADriveWithoutDummyMappingIsToldOf) {
    SimPort port(options_of("no-dummy"));
    DriveClient drive(port, 1);
    const Tally tally = run_all(drive, false);
    EXPECT_TRUE(tally.failed.empty()) << list_of(tally.failed);
    EXPECT_EQ(tally.left_out, 1);
}

/// What is wrong in a drive must show: a port that spoils its frames.
class SpoiledPort final : public DrivePort {
public:
    using Spoil = void (*)(std::vector<Frame>&);
    explicit SpoiledPort(Spoil spoil) : port_(options_of()), spoil_(spoil) {}
    void send(const Frame& frame) override { port_.send(frame); }
    std::vector<Frame> cycle() override { return spoiled(port_.cycle()); }
    std::vector<Frame> answers() override { return spoiled(port_.answers()); }
    [[nodiscard]] double cycle_ms() const override { return 2.0; }

private:
    std::vector<Frame> spoiled(std::vector<Frame> frames) {
        spoil_(frames);
        return frames;
    }
    SimPort port_;
    Spoil spoil_;
};

bool fails_in(SpoiledPort::Spoil spoil, const std::string& group) {
    SpoiledPort port(spoil);
    DriveClient drive(port, 1);
    for (const Case& one : all_cases()) {
        if (one.group == group && one.run(drive).verdict == Verdict::failed) {
            return true;
        }
    }
    return false;
}

TEST(DriveCheck, WhatADriveDoesWrongIsFound) {
    EXPECT_TRUE(fails_in(
        [](std::vector<Frame>& frames) { std::erase_if(frames, [](const Frame& f) { return f.id == 0x701; }); },
        "NMT"));
    EXPECT_TRUE(fails_in(
        [](std::vector<Frame>& frames) { std::erase_if(frames, [](const Frame& f) { return f.id == 0x081; }); },
        "EMCY"));
    EXPECT_TRUE(fails_in(
        [](std::vector<Frame>& frames) {
            for (Frame& f : frames) {
                if (f.id == 0x581 && f.data[0] == 0x80) {
                    f.data[4] ^= 1U;
                }
            }
        },
        "SDO"));
    EXPECT_TRUE(fails_in(
        [](std::vector<Frame>& frames) {
            for (Frame& f : frames) {
                if (f.id == 0x581 && (f.data[0] & 0xE0U) == 0) {
                    f.data[0] ^= 0x10U;
                }
            }
        },
        "SDO segmented"));
    EXPECT_TRUE(fails_in(
        [](std::vector<Frame>& frames) {
            for (Frame& f : frames) {
                if (f.id == 0x181) {
                    f.data[0] &= 0xFBU;
                }
            }
        },
        "states"));
}

/// The same over packets as SocketCAN has them, the drive in a thread of its own.
TEST(DriveCheck, PassesOverACanSocket) {
    std::array<int, 2> files{};
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET, 0, files.data()), 0);
    CanPort port{socketcan::CanSocket{files.front()}, 2.0, false, 300};
    port.fence(1);
    DriveClient drive(port, 1);
    drive_process::DriveProcess process{socketcan::CanSocket{files.back()}, {options_of()}, kCycleNs};
    std::atomic<bool> stop{false};
    std::thread thread([&process, &stop] { process.run(stop); });
    const Tally tally = run_all(drive, false);
    stop.store(true);
    thread.join();
    EXPECT_EQ(process.counters().lost, 0U);
    EXPECT_TRUE(tally.failed.empty()) << list_of(tally.failed);
    EXPECT_EQ(tally.left_out, 0);
}

}  // namespace
}  // namespace sc::drive_check
