// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/optics/galvo_status.hpp"

#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "firmware/hal/io.hpp"
#include "tests/stm32h743/model/status_spi.hpp"

namespace sc::stm32h743 {
namespace {

class GalvoStatusTest : public testing::Test {
protected:
    GalvoStatusTest() {
        machine.attach(model::ClockGates::kBase, 0x400, clocks);
        machine.attach(model::DmaModel::kBase, 0x400, dma);
        machine.attach(model::DmaModel::kMuxBase, 0x20, dma.mux);
        machine.map_memory(0x30000000, std::span(reinterpret_cast<std::uint8_t*>(buffer.get()), sizeof *buffer));
        line.set(kGalvoStatusOk);
    }
    void TearDown() override { EXPECT_EQ(machine.violations_text(), ""); }
    void frames(int count) {
        for (int i = 0; i < 20 * count; ++i) {
            line.clock();
        }
    }

    model::Machine machine;
    model::ClockGates clocks{machine};
    model::DmaModel dma{machine, clocks};
    model::SlowPort port{machine, clocks, 2};
    model::StatusSpi spi{machine, clocks, dma, port};
    model::StatusLine line{spi};
    std::unique_ptr<StatusBuffer> buffer = std::make_unique<StatusBuffer>();
    GalvoStatus status{*buffer};
};

TEST_F(GalvoStatusTest, TellsTheNewestWord) {
    ASSERT_TRUE(status.start());
    std::mt19937 random(3);
    for (int i = 0; i < 500; ++i) {
        const auto word = static_cast<std::uint16_t>(random());
        frames(static_cast<int>(random() % 20));
        line.set(word);
        frames(1);
        EXPECT_EQ(status.word(), word);
    }
    EXPECT_EQ(status.overruns(), 0U);
}

TEST_F(GalvoStatusTest, TheHealthyWordReadsAsHealthy) {
    ASSERT_TRUE(status.start());
    frames(10);
    EXPECT_EQ(status.word(), kGalvoStatusOk);
}

TEST_F(GalvoStatusTest, WithoutAClockThereIsNone) {
    ASSERT_TRUE(status.start());
    EXPECT_EQ(status.word(), 0);
    frames(3);
    EXPECT_EQ(status.word(), kGalvoStatusOk);
    EXPECT_EQ(status.word(), 0);
}

TEST_F(GalvoStatusTest, ALineThatHangsIsNotHealthy) {
    ASSERT_TRUE(status.start());
    frames(3);
    for (const bool level : {false, true}) {
        line.hang(true, level);
        frames(3);
        EXPECT_FALSE(galvo_healthy(status.word()));
    }
    line.hang(false);
    frames(3);
    EXPECT_TRUE(galvo_healthy(status.word()));
}

/// Bits that are lost for good turn the words; none of the turns reads as healthy.
TEST_F(GalvoStatusTest, ALostBitIsSeenForGood) {
    ASSERT_TRUE(status.start());
    frames(2);
    for (int lost = 1; lost < 20; ++lost) {
        line.slip();
        frames(3);
        EXPECT_FALSE(galvo_healthy(status.word())) << lost;
    }
    line.slip();
    frames(3);
    EXPECT_TRUE(galvo_healthy(status.word()));
}

TEST_F(GalvoStatusTest, AWordThatNobodyFetchesIsCountedAndIsNone) {
    ASSERT_TRUE(status.start());
    frames(2);
    ASSERT_EQ(status.word(), kGalvoStatusOk);
    machine.write(0x40003C00, 0, 4);
    machine.write(0x40003C08, 0x00070013, 4);  // without DMA
    machine.write(0x40003C00, 1, 4);
    frames(3);
    EXPECT_EQ(status.word(), 0);
    EXPECT_EQ(status.overruns(), 1U);
    EXPECT_EQ(machine.read(0x40003C14) & 0x40U, 0U);
}

TEST_F(GalvoStatusTest, MayBeStartedAgainInTheMidstOfAFrame) {
    ASSERT_TRUE(status.start());
    for (int i = 0; i < 27; ++i) {
        line.clock();
    }
    for (int i = 0; i < 13; ++i) {
        line.clock();
    }
    ASSERT_TRUE(status.start());
    frames(2);
    EXPECT_EQ(status.word(), kGalvoStatusOk);
}

}  // namespace
}  // namespace sc::stm32h743
