// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/formats/capture_file.hpp"
#include "host/formats/error.hpp"
#include "host/protocol/capture_decoder.hpp"
#include "shared/link/can_record.hpp"
#include "shared/link/serial.hpp"

namespace {

using namespace sc;  // NOLINT(google-build-using-namespace): a test
using host::CaptureKind;

std::filesystem::path scratch(const std::string& name) {
    return std::filesystem::path(testing::TempDir()) / ("capture_" + name);
}

std::vector<std::uint8_t> heartbeat(std::uint16_t counter) {
    std::array<std::uint8_t, link::kSerialCapacity> bytes{};
    const std::size_t size = link::encode_serial(link::Heartbeat{0x1122'3344'5566'7788ULL}, counter, bytes);
    return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)};
}

std::string refusal(const std::filesystem::path& file) {
    try {
        (void)host::read_capture(file);
    } catch (const host::InputError& error) {
        return error.what();
    }
    return "";
}

TEST(CaptureFile, CutsBytesAtTheEndsOfFramesAndKeepsTimes) {
    const auto file = scratch("serial.pcap");
    {
        host::CaptureWriter writer(file, CaptureKind::serial);
        const std::array<std::uint8_t, 5> bytes{1, 2, 0, 3, 4};
        writer.serial(true, bytes, 1'000'000'007);
        writer.serial(false, std::span(bytes).first(3), 2'000'000'000);
        writer.serial(true, std::span(bytes).subspan(2, 1), 3'500'000'000);
    }
    const host::CaptureFile capture = host::read_capture(file);
    ASSERT_EQ(capture.packets.size(), 3U);
    EXPECT_EQ(capture.kind, CaptureKind::serial);
    EXPECT_EQ(capture.packets[0].bytes, (std::vector<std::uint8_t>{1, 1, 2, 0}));
    EXPECT_EQ(capture.packets[0].time_ns, 1'000'000'007);
    EXPECT_EQ(capture.packets[1].bytes, (std::vector<std::uint8_t>{0, 1, 2, 0}));
    EXPECT_EQ(capture.packets[2].bytes, (std::vector<std::uint8_t>{1, 3, 4, 0}));
    EXPECT_EQ(capture.packets[2].time_ns, 3'500'000'000);
}

TEST(CaptureFile, RefusesWhatIsNoCaptureAndSaysWhatToDo) {
    const auto file = scratch("bad.pcap");
    std::ofstream(file) << "no capture at all, but long enough for a head";
    EXPECT_NE(refusal(file).find("no pcap file"), std::string::npos) << refusal(file);
    std::ofstream(file) << "short";
    EXPECT_NE(refusal(file).find("too short"), std::string::npos);
    {
        host::CaptureWriter(file, CaptureKind::can).can({0x100, false, {1, 2, 3}}, 5);
    }
    std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1);
    EXPECT_NE(refusal(file).find("cut within packet: 1"), std::string::npos) << refusal(file);
    EXPECT_THROW(host::CaptureWriter("/nowhere/at/all.pcap", CaptureKind::can), host::InputError);
}

TEST(CaptureFile, ADiskThatIsFullEndsTheFileAndSaysSo) {
    host::CaptureWriter writer("/dev/full", CaptureKind::serial);
    const std::vector<std::uint8_t> bytes(200'000, 0);
    writer.serial(true, bytes, 0);
    writer.close();
    EXPECT_NE(writer.error().find("/dev/full"), std::string::npos);
}

TEST(CaptureDecoder, TellsFieldsLossesAndSpoiltFrames) {
    const auto file = scratch("losses.pcap");
    {
        host::CaptureWriter writer(file, CaptureKind::serial);
        writer.serial(true, heartbeat(10), 1);
        writer.serial(true, heartbeat(10), 2);
        writer.serial(true, heartbeat(14), 3);
        std::vector<std::uint8_t> spoilt = heartbeat(15);
        spoilt[5] = spoilt[5] == 9 ? 8 : 9;
        writer.serial(true, spoilt, 4);
    }
    const host::DecodedCapture capture = host::decode_capture(file);
    ASSERT_EQ(capture.messages.size(), 3U);
    EXPECT_EQ(capture.messages[0].name, "heartbeat");
    EXPECT_EQ(capture.messages[0].fields["host_time_us"], 0x1122'3344'5566'7788ULL);
    EXPECT_EQ(capture.messages[0].lost, 0U);
    EXPECT_TRUE(capture.messages[1].repeated);
    EXPECT_EQ(capture.messages[2].lost, 3U);
    EXPECT_EQ(capture.to_controller.checks_failed + capture.to_controller.frames_bad, 1U);
    EXPECT_EQ(capture.to_host.checks_failed, 0U);
}

TEST(CanRecord, IsReadAsItWasWrittenAndRefusesOtherKinds) {
    link::LinkCanFrame frame;
    frame.id = 0x123;
    frame.size = 3;
    frame.data[0] = 1;
    frame.data[2] = 9;
    for (const bool fd : {false, true}) {
        frame.fd = fd;
        std::vector<std::uint8_t> bytes(link::can_record_size(fd), 0xFF);
        link::put_can_record(frame, bytes);
        EXPECT_EQ(link::get_can_record(bytes, fd), frame);
        bytes[4] = fd ? 9 : 12;
        EXPECT_FALSE(link::get_can_record(bytes, fd));
        bytes[4] = 3;
        bytes[5] ^= link::kCanRecordFd;
        EXPECT_FALSE(link::get_can_record(bytes, fd));
    }
}

}  // namespace
