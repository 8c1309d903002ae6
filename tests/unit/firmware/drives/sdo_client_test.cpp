// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/sdo_client.hpp"

#include <gtest/gtest.h>

namespace sc::drives {
namespace {

constexpr canopen::ObjectKey kMode{0x6060, 0, 1};
constexpr canopen::ObjectKey kDisplay{0x6061, 0, 1};

DriveFrame reply(std::uint8_t command, std::uint16_t index, std::uint8_t value) {
    DriveFrame frame;
    frame.id = 0x581;
    frame.size = 8;
    frame.data = {command, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8U), 0, value};
    return frame;
}

TEST(SdoClient, WritesAndIsDoneWhenConfirmed) {
    SdoClient sdo;
    EXPECT_EQ(sdo.result(), SdoClient::Result::idle);
    EXPECT_FALSE(sdo.poll(1, 0));
    sdo.write(kMode, 8);
    const auto frame = sdo.poll(1, 0);
    ASSERT_TRUE(frame);
    EXPECT_EQ(*frame, canopen::sdo_download(1, kMode, 8));
    EXPECT_FALSE(sdo.poll(1, 1)) << "one request at a time";
    EXPECT_EQ(sdo.result(), SdoClient::Result::busy);
    sdo.receive(reply(0x60, 0x6060, 0));
    EXPECT_EQ(sdo.result(), SdoClient::Result::done);
}

TEST(SdoClient, ReadsAValue) {
    SdoClient sdo;
    sdo.read(kDisplay);
    ASSERT_TRUE(sdo.poll(1, 0));
    sdo.receive(reply(0x4F, 0x6061, 6));
    EXPECT_EQ(sdo.result(), SdoClient::Result::done);
    EXPECT_EQ(sdo.value(), 6U);
}

TEST(SdoClient, IgnoresAnswersToOtherRequests) {
    SdoClient sdo;
    sdo.read(kDisplay);
    sdo.receive(reply(0x4F, 0x6061, 6));
    EXPECT_EQ(sdo.result(), SdoClient::Result::busy) << "an answer before the question is a late one";
    ASSERT_TRUE(sdo.poll(1, 0));
    sdo.receive(reply(0x4F, 0x6060, 6));
    sdo.receive(reply(0x60, 0x6061, 0));
    EXPECT_EQ(sdo.result(), SdoClient::Result::busy);
}

TEST(SdoClient, KeepsTheAbortCode) {
    SdoClient sdo;
    sdo.write(kMode, 1);
    ASSERT_TRUE(sdo.poll(1, 0));
    DriveFrame abort = reply(0x80, 0x6060, 0x30);
    abort.data[6] = 0x09;
    abort.data[7] = 0x06;
    sdo.receive(abort);
    EXPECT_EQ(sdo.result(), SdoClient::Result::aborted);
    EXPECT_EQ(sdo.value(), 0x06090030U);
}

TEST(SdoClient, RepeatsThenTimesOut) {
    SdoClient sdo;
    sdo.write(kMode, 8);
    int sent = 0;
    std::int64_t tick = 0;
    for (; tick < 1000 && sdo.result() == SdoClient::Result::busy; ++tick) {
        sent += sdo.poll(1, tick) ? 1 : 0;
    }
    EXPECT_EQ(sent, SdoClient::kAttempts);
    EXPECT_EQ(sdo.result(), SdoClient::Result::timed_out);
    EXPECT_EQ(tick - 1, SdoClient::kTimeoutTicks * SdoClient::kAttempts);
}

TEST(SdoClient, AnswerToTheRepetitionCounts) {
    SdoClient sdo;
    sdo.write(kMode, 8);
    ASSERT_TRUE(sdo.poll(1, 0));
    ASSERT_TRUE(sdo.poll(1, SdoClient::kTimeoutTicks));
    sdo.receive(reply(0x60, 0x6060, 0));
    EXPECT_EQ(sdo.result(), SdoClient::Result::done);
}

}  // namespace
}  // namespace sc::drives
