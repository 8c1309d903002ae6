// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/galvo.hpp"

#include <bitset>
#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace sc::sim {
namespace {

/// Frame of a 16-bit wire position by the text of the protocol: 001, the position, even parity over all.
std::uint32_t word_of(std::uint32_t position) {
    const std::uint32_t body = 0x20000U | (position << 1U);
    return body | static_cast<std::uint32_t>(std::bitset<20>(body).count() % 2);
}
std::uint32_t word_at(const MachineConfig& machine, double metres) {
    return word_of(static_cast<std::uint32_t>(0x8000 + std::lround(metres * machine.galvo.counts_per_metre)));
}

TEST(Xy2_100, DecodesTheKnownFrames) {
    const std::pair<std::uint32_t, std::uint16_t> known[] = {{0x20001, 0x0000}, {0x22468, 0x1234}, {0x2FFFE, 0x7FFF},
                                                             {0x30000, 0x8000}, {0x30003, 0x8001}, {0x38001, 0xC000},
                                                             {0x3FFFF, 0xFFFF}};
    for (const auto& [word, position] : known) {
        EXPECT_EQ(decode_xy2_100(word), position);
    }
}

TEST(Xy2_100, DropsEveryWordWithOneBitWrong) {
    std::mt19937 random(3);
    for (int i = 0; i < 1000; ++i) {
        const std::uint32_t good = word_of(random() & 0xFFFFU);
        ASSERT_TRUE(decode_xy2_100(good));
        for (unsigned bit = 0; bit < 20; ++bit) {
            EXPECT_FALSE(decode_xy2_100(good ^ (1U << bit)));
        }
    }
    EXPECT_FALSE(decode_xy2_100(0));
    EXPECT_FALSE(decode_xy2_100(0xFFFFFFFFU));
    // Even parity, but control bits 010 and 000.
    EXPECT_FALSE(decode_xy2_100(0x40001));
    EXPECT_FALSE(decode_xy2_100(0x00003));
    EXPECT_FALSE(decode_xy2_100(0x100000U | 0x20000U));
}

TEST(Xy2_100, EighteenBitsHaveOneControlBitAndOddParity) {
    EXPECT_EQ(decode_xy2_100_18(0xC0001), 0x20000U);
    EXPECT_FALSE(decode_xy2_100_18(0xC0000));
    EXPECT_FALSE(decode_xy2_100_18(0x40000)) << "no control bit";
    EXPECT_FALSE(decode_xy2_100_18(0x20001)) << "a word of 16 bits";
}

class Galvo : public testing::Test {
protected:
    MachineConfig machine_ = reference_machine();
    GalvoTruth truth_;
};

TEST_F(Galvo, FollowsConstantSpeedAtExactlyTheTrackingTime) {
    for (const double tracking : {160e-6, 173e-6, 150e-6}) {
        truth_.tracking = tracking;
        machine_.galvo.counts_per_metre = 1e7;  // no grid worth mentioning, within 16 bits for 3 mm
        GalvoPlant galvo(machine_, truth_);
        const double speed = 0.5;
        double last = 0.0;
        for (int k = 0; k < 500; ++k) {
            last = speed * (k * 1e-5) - 1.25e-3;
            galvo.play(word_at(machine_, last), word_at(machine_, -last));
        }
        // Frame 499 left at 4.99 ms; the state is that of 5 ms.
        const double expected = last + speed * 1e-5 - speed * tracking;
        EXPECT_NEAR(galvo.state().place[0], expected, 0.1e-6);
        EXPECT_NEAR(galvo.state().place[1], -expected, 0.1e-6);
        EXPECT_NEAR(galvo.state().speed[0], speed, 0.01);
    }
}

TEST_F(Galvo, DelayIsWhatHoldAndServoLeave) {
    const GalvoPlant galvo(machine_, truth_);
    // 160 - 5 - 2 · 0.75 / (2 pi · 2 kHz) = 35.634 us
    EXPECT_NEAR(galvo.delay(), 35.634e-6, 1e-9);
}

TEST_F(Galvo, StepHasTheServosDelayOvershootAndRest) {
    GalvoPlant galvo(machine_, truth_);
    const double target = std::round(0.01 * machine_.galvo.counts_per_metre) / machine_.galvo.counts_per_metre;
    const std::uint32_t word = word_at(machine_, target);
    double peak = 0.0;
    int peak_frame = 0;
    for (int k = 0; k < 400; ++k) {
        galvo.play(word, word_of(0x8000));
        if (k < 3) {
            EXPECT_EQ(galvo.state().place[0], 0.0);
        }
        if (galvo.state().place[0] > peak) {
            peak = galvo.state().place[0];
            peak_frame = k + 1;
        }
    }
    // Overshoot exp(-pi zeta / sqrt(1 - zeta²)) = 2.84 % at delay + pi / wd = 413.6 us.
    EXPECT_NEAR(peak / target, 1.02838, 2e-4);
    EXPECT_NEAR(peak_frame, 41.4, 1.0);
    EXPECT_DOUBLE_EQ(galvo.state().place[0], target);
    EXPECT_EQ(galvo.state().speed[0], 0.0);
    EXPECT_EQ(galvo.state().place[1], 0.0);
}

TEST_F(Galvo, BadParityHoldsTheMirrorAndCounts) {
    GalvoPlant galvo(machine_, truth_);
    const std::uint32_t good = word_at(machine_, 0.004);
    for (int k = 0; k < 500; ++k) {
        galvo.play(good, good);
    }
    const Deflection before = galvo.state();
    for (int k = 0; k < 500; ++k) {
        galvo.play(word_at(machine_, -0.008) ^ 1U, good);
    }
    EXPECT_EQ(galvo.state().place, before.place);
    EXPECT_EQ(galvo.dropped(), 500U);
    for (int k = 0; k < 500; ++k) {
        galvo.play(word_at(machine_, -0.008), good);
    }
    EXPECT_NEAR(galvo.state().place[0], -0.008, 1e-6);
    EXPECT_EQ(galvo.dropped(), 500U);
}

TEST_F(Galvo, BothConventionsOfTheHead) {
    machine_.galvo.convention = GalvoConvention::twos_complement;
    GalvoPlant galvo(machine_, truth_);
    for (int k = 0; k < 500; ++k) {
        galvo.play(word_of(0xFFFF), word_of(0x0001));
    }
    EXPECT_NEAR(galvo.state().place[0] * machine_.galvo.counts_per_metre, -1.0, 1e-9);
    EXPECT_NEAR(galvo.state().place[1] * machine_.galvo.counts_per_metre, 1.0, 1e-9);
}

TEST_F(Galvo, FailureShowsInTheStatusWordAndStopsTheMirrors) {
    GalvoPlant galvo(machine_, truth_);
    EXPECT_EQ(galvo.status(), 0xFDFD);
    for (int k = 0; k < 10; ++k) {
        galvo.play(word_at(machine_, 0.01), word_of(0x8000));
    }
    galvo.fail(true);
    EXPECT_NE(galvo.status(), 0xFDFD);
    const double place = galvo.state().place[0];
    for (int k = 0; k < 100; ++k) {
        galvo.play(word_at(machine_, 0.01), word_of(0x8000));
    }
    EXPECT_EQ(galvo.state().place[0], place);
    galvo.fail(false);
    EXPECT_TRUE(galvo_healthy(galvo.status()));
}

TEST_F(Galvo, AcknowledgesOnlyAMirrorThatHasArrived) {
    GalvoPlant galvo(machine_, truth_);
    galvo.play(word_at(machine_, 0.002), word_of(0x8000));
    EXPECT_EQ(galvo.status(), 0xFDFD & ~0x0808) << "x is on its way";
    for (int k = 0; k < 200; ++k) {
        galvo.play(word_at(machine_, 0.002), word_of(0x8000));
    }
    EXPECT_EQ(galvo.status(), 0xFDFD);
    galvo.play(word_at(machine_, 0.002), word_at(machine_, -0.002));
    EXPECT_EQ(galvo.status(), 0xFDFD & ~0x1010) << "z is on its way";
}

TEST_F(Galvo, WithoutAHeadTheLineSaysWhatItSays) {
    GalvoPlant galvo(machine_, truth_);
    galvo.unplug(0xFDFD);
    galvo.play(word_at(machine_, 0.01), word_of(0x8000));
    EXPECT_EQ(galvo.status(), 0xFDFD);
    EXPECT_EQ(galvo.state().place[0], 0.0);
    galvo.unplug(0xFFFF);
    EXPECT_EQ(galvo.status(), 0xFFFF);
}

TEST_F(Galvo, WordsOfEighteenBitsHaveAQuarterOfTheGrid) {
    machine_.galvo.word = GalvoWord::bits18;
    for (const GalvoConvention convention : {GalvoConvention::offset_binary, GalvoConvention::twos_complement}) {
        machine_.galvo.convention = convention;
        GalvoPlant galvo(machine_, truth_);
        const std::uint32_t zero = convention == GalvoConvention::offset_binary ? 0x20000 : 0;
        const auto word = [](std::uint32_t data) {
            const std::uint32_t body = 0x80000U | (data << 1U);
            return body | static_cast<std::uint32_t>((std::bitset<20>(body).count() + 1) % 2);
        };
        for (int k = 0; k < 500; ++k) {
            galvo.play(word(zero + 400), word((zero - 400) & 0x3FFFFU));
        }
        EXPECT_NEAR(galvo.state().place[0] * machine_.galvo.counts_per_metre, 100.0, 1e-9);
        EXPECT_NEAR(galvo.state().place[1] * machine_.galvo.counts_per_metre, -100.0, 1e-9);
        EXPECT_EQ(galvo.dropped(), 0U);
    }
}

TEST_F(Galvo, RefusesAServoSlowerThanItsTracking) {
    truth_.natural_frequency = 1400.0;
    truth_.damping = 0.8;
    EXPECT_THROW(GalvoPlant(machine_, truth_), std::invalid_argument);
}

TEST_F(Galvo, InterpolationMatchesAFinerPlant) {
    // The same ramp, asked at 2.5 us within a 10 us frame: against the analytic lag.
    machine_.galvo.counts_per_metre = 1e7;
    GalvoPlant galvo(machine_, truth_);
    Deflection before;
    for (int k = 0; k < 300; ++k) {
        before = galvo.state();
        galvo.play(word_at(machine_, 1.0 * (k * 1e-5) - 1.5e-3), word_of(0x8000));
    }
    for (const double fraction : {0.0, 0.25, 0.5, 0.9, 1.0}) {
        const double expected = 1.0 * ((299 + fraction) * 1e-5 - 160e-6) - 1.5e-3;
        EXPECT_NEAR(between(before, galvo.state(), fraction, 1e-5)[0], expected, 0.1e-6);
    }
}

}  // namespace
}  // namespace sc::sim
