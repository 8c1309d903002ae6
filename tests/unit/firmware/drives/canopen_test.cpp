// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/canopen.hpp"

#include <gtest/gtest.h>

namespace sc::drives::canopen {
namespace {

DriveFrame frame(std::uint16_t id, std::initializer_list<int> bytes) {
    DriveFrame out;
    out.id = id;
    for (const int byte : bytes) {
        out.data.at(out.size++) = static_cast<std::uint8_t>(byte);
    }
    return out;
}

TEST(Canopen, NetworkFrames) {
    EXPECT_EQ(nmt(NmtCommand::start, 3), frame(0x000, {0x01, 3}));
    EXPECT_EQ(nmt(NmtCommand::reset_node, 4), frame(0x000, {0x81, 4}));
    EXPECT_EQ(sync(), frame(0x080, {}));
    EXPECT_EQ(heartbeat(127, NmtState::operational), frame(0x77F, {0x05}));
}

TEST(Canopen, TargetPdoIsLittleEndian) {
    EXPECT_EQ(rpdo1(2, 0x000F, 0x12345678), frame(0x202, {0x0F, 0x00, 0x78, 0x56, 0x34, 0x12}));
    EXPECT_EQ(rpdo1(1, 0x0006, -2), frame(0x201, {0x06, 0x00, 0xFE, 0xFF, 0xFF, 0xFF}));
    EXPECT_EQ(rpdo1(1, 0, INT32_MIN), frame(0x201, {0, 0, 0, 0, 0, 0x80}));
}

TEST(Canopen, ExpeditedRequestsOfEverySize) {
    EXPECT_EQ(sdo_download(1, {0x6060, 0, 1}, 8), frame(0x601, {0x2F, 0x60, 0x60, 0, 8, 0, 0, 0}));
    EXPECT_EQ(sdo_download(1, {0x1017, 0, 2}, 20), frame(0x601, {0x2B, 0x17, 0x10, 0, 20, 0, 0, 0}));
    EXPECT_EQ(sdo_download(5, {0x1600, 1, 4}, 0x60400010), frame(0x605, {0x23, 0x00, 0x16, 1, 0x10, 0x00, 0x40, 0x60}));
    EXPECT_EQ(sdo_upload(1, {0x6061, 0, 1}), frame(0x601, {0x40, 0x61, 0x60, 0, 0, 0, 0, 0}));
}

TEST(Canopen, ReadsEveryKindOfReply) {
    const auto written = read_sdo_reply(frame(0x581, {0x60, 0x60, 0x60, 0, 0, 0, 0, 0}));
    ASSERT_TRUE(written);
    EXPECT_FALSE(written->upload);
    EXPECT_EQ(written->key.index, 0x6060);
    const auto byte = read_sdo_reply(frame(0x581, {0x4F, 0x61, 0x60, 0, 8, 0xAA, 0xBB, 0xCC}));
    ASSERT_TRUE(byte);
    EXPECT_TRUE(byte->upload);
    EXPECT_EQ(byte->value, 8U) << "bytes beyond the size are not read";
    EXPECT_EQ(byte->key.size, 1);
    EXPECT_EQ(read_sdo_reply(frame(0x581, {0x4B, 0, 0, 0, 1, 2, 9, 9}))->value, 0x0201U);
    EXPECT_EQ(read_sdo_reply(frame(0x581, {0x43, 0, 0, 0, 1, 2, 3, 4}))->value, 0x04030201U);
    const auto aborted = read_sdo_reply(frame(0x581, {0x80, 0x02, 0x65, 0, 0, 0, 0x02, 0x06}));
    ASSERT_TRUE(aborted);
    EXPECT_TRUE(aborted->aborted);
    EXPECT_EQ(aborted->value, 0x06020000U);
}

TEST(Canopen, RefusesWhatIsNoReply) {
    EXPECT_FALSE(read_sdo_reply(frame(0x581, {0x60, 0x60, 0x60, 0, 0, 0, 0})));
    EXPECT_FALSE(read_sdo_reply(frame(0x581, {0x41, 0, 0, 0, 0, 0, 0, 0}))) << "segmented upload";
    EXPECT_FALSE(read_sdo_reply(frame(0x581, {0x00, 0, 0, 0, 0, 0, 0, 0})));
    EXPECT_FALSE(read_tpdo1(frame(0x181, {0, 0, 0, 0, 0})));
    EXPECT_FALSE(read_tpdo1(frame(0x181, {0, 0, 0, 0, 0, 0, 0, 0})));
    EXPECT_FALSE(read_emergency(frame(0x081, {0})));
}

TEST(Canopen, ReadsStatusAndEmergency) {
    const auto status = read_tpdo1(frame(0x181, {0x37, 0x12, 0xFF, 0xFF, 0xFF, 0xFF}));
    ASSERT_TRUE(status);
    EXPECT_EQ(status->statusword, 0x1237);
    EXPECT_EQ(status->actual, -1);
    const auto emergency = read_emergency(frame(0x081, {0x11, 0x86, 0x21, 0, 0, 0, 0, 0}));
    ASSERT_TRUE(emergency);
    EXPECT_EQ(emergency->error_code, 0x8611);
    EXPECT_EQ(emergency->error_register, 0x21);
}

}  // namespace
}  // namespace sc::drives::canopen
