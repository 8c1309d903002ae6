// SPDX-License-Identifier: Apache-2.0
#include "firmware/laser/head_proof.hpp"

#include <functional>

#include <gtest/gtest.h>

namespace sc::laser {
namespace {

/// A head's answer at the next sample, given the last 100 us of frames of the window before and its mirrors' places.
using Head = std::function<std::uint16_t(const std::array<GalvoFrame, kGalvoFramesPerTick>&)>;

/// A head that acknowledges a mirror whose word has not changed within the last 30 frames of the window.
std::uint16_t good_head(const std::array<GalvoFrame, kGalvoFramesPerTick>& frames) {
    std::uint16_t status = kGalvoStatusOk;
    const GalvoFrame& earlier = frames[kGalvoFramesPerTick - 31];
    const GalvoFrame& last = frames.back();
    if (earlier.word_x != last.word_x) {
        status = static_cast<std::uint16_t>(status & ~0x0808U);
    }
    if (earlier.word_z != last.word_z) {
        status = static_cast<std::uint16_t>(status & ~0x1010U);
    }
    return status;
}

struct Outcome {
    bool proven = false;
    bool failed = false;
    int ticks = 0;
    std::array<GalvoFrame, kGalvoFramesPerTick> last{};
    int moved_x = 0;  ///< most counts that a word was displaced
    int moved_z = 0;
};

Outcome prove(const Head& head, GalvoConfig config, int at_x = 0, int at_z = 0) {
    HeadProof proof(config);
    const WordFormat format(config.word, config.convention);
    Outcome outcome;
    // Outputs of tick n act in the window that ends where tick n + 2 samples.
    std::array<GalvoFrame, kGalvoFramesPerTick> acting{};
    acting.fill({0, 0, format.word(at_x), format.word(at_z)});
    std::array<GalvoFrame, kGalvoFramesPerTick> next = acting;
    for (int tick = 0; tick < 200 && !outcome.proven && !outcome.failed; ++tick) {
        const std::uint16_t status = head(acting);
        acting = next;
        next.fill({0, 0, format.word(at_x), format.word(at_z)});
        proof.step(status, next);
        for (const GalvoFrame& frame : next) {
            outcome.moved_x = std::max(outcome.moved_x, std::abs(format.position(frame.word_x) - at_x));
            outcome.moved_z = std::max(outcome.moved_z, std::abs(format.position(frame.word_z) - at_z));
        }
        outcome = {proof.proven(), proof.failed(), tick + 1, next, outcome.moved_x, outcome.moved_z};
    }
    return outcome;
}

class HeadProofOf : public testing::TestWithParam<GalvoWord> {
protected:
    GalvoConfig config() const {
        GalvoConfig config = reference_machine().galvo;
        config.word = GetParam();
        return config;
    }
};

TEST_P(HeadProofOf, AHeadThatAnswersIsProvenAndItsMirrorsAreBackWhereTheyWere) {
    const int edge = config().word == GalvoWord::bits18 ? 131'000 : 32'700;
    for (const auto& [x, z] : {std::pair{0, 0}, std::pair{edge, -edge}}) {
        const Outcome outcome = prove(good_head, config(), x, z);
        EXPECT_TRUE(outcome.proven);
        EXPECT_LE(outcome.ticks, 30);
        const WordFormat format(config().word, config().convention);
        EXPECT_EQ(format.position(outcome.last.back().word_x), x);
        EXPECT_EQ(format.position(outcome.last.back().word_z), z);
        const int jump = config().word == GalvoWord::bits18 ? 4 * 1638 : 1638;
        EXPECT_EQ(outcome.moved_x, jump);
        EXPECT_EQ(outcome.moved_z, jump);
    }
}

TEST_P(HeadProofOf, NoConstantWordPassesForAHead) {
    // All 65 536 words of a line on which nothing answers, the "all well" of a converter without a head among them.
    for (std::uint32_t word = 0; word <= 0xFFFF; ++word) {
        const Outcome outcome = prove([word](const auto&) { return static_cast<std::uint16_t>(word); }, config());
        ASSERT_TRUE(outcome.failed && !outcome.proven) << std::hex << word;
    }
}

TEST_P(HeadProofOf, WrongAnswersFail) {
    const auto swapped = [](const auto& frames) {
        const std::uint16_t s = good_head(frames);
        const bool x = (s & 0x0808U) == 0;
        const bool z = (s & 0x1010U) == 0;
        return static_cast<std::uint16_t>(kGalvoStatusOk & ~(x ? 0x1010U : 0U) & ~(z ? 0x0808U : 0U));
    };
    EXPECT_TRUE(prove(swapped, config()).failed) << "x and z exchanged";
    const auto both = [](const auto& frames) {
        return good_head(frames) == kGalvoStatusOk ? kGalvoStatusOk : std::uint16_t{0xE5E5};
    };
    EXPECT_TRUE(prove(both, config()).failed) << "both at once";
    int calls = 0;
    const auto stays = [&calls](const auto& frames) {
        static_cast<void>(frames);
        return ++calls < 4 ? kGalvoStatusOk : std::uint16_t{0xF5F5};
    };
    EXPECT_TRUE(prove(stays, config()).failed) << "falls and never returns";
}

INSTANTIATE_TEST_SUITE_P(Formats, HeadProofOf, testing::Values(GalvoWord::bits16, GalvoWord::bits18));

TEST(HeadProof, RestartForgets) {
    HeadProof proof(reference_machine().galvo);
    std::array<GalvoFrame, kGalvoFramesPerTick> frames{};
    for (int tick = 0; tick < 30; ++tick) {
        proof.step(0, frames);
    }
    ASSERT_TRUE(proof.failed());
    proof.restart();
    EXPECT_FALSE(proof.failed());
    EXPECT_FALSE(proof.proven());
}

TEST(GalvoStatus, HealthyMeansEveryFixedBitAndBothBytes) {
    int healthy = 0;
    for (std::uint32_t word = 0; word <= 0xFFFF; ++word) {
        const bool ok = galvo_healthy(static_cast<std::uint16_t>(word));
        healthy += ok ? 1 : 0;
        if (ok) {
            // Power, temperature, bits 5, 2 and 0 set, bit 1 clear, in both bytes.
            EXPECT_EQ(word & 0xE7E7U, 0xE5E5U);
        }
    }
    EXPECT_EQ(healthy, 4) << "either mirror may be on its way";
}

}  // namespace
}  // namespace sc::laser
