// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "firmware/recording/io_image.hpp"
#include "image_path.hpp"
#include "shared/hash/sha256.hpp"
#include "tests/sim/firmware/controller/cell_rig.hpp"

namespace sc::mps2_an500 {
namespace {

/// Hands ticks on and digests the image of every tick's outputs.
class Digesting final : public sim::ControllerHost {
public:
    Digesting(std::unique_ptr<ControllerHost> inner, Sha256& digest) : inner_(std::move(inner)), digest_(digest) {}
    void tick(const ServoInputs& inputs, ServoOutputs& outputs) override {
        inner_->tick(inputs, outputs);
        const std::size_t size = recording::pack(outputs, image_);
        ASSERT_GT(size, 0U);
        digest_.update(std::span(image_).first(size));
    }
    void fit_key(const link::SealSecret& secret) override { inner_->fit_key(secret); }
    [[nodiscard]] Fault first_fault() const override { return inner_->first_fault(); }
    [[nodiscard]] std::string board() const override { return inner_->board(); }
    [[nodiscard]] std::optional<sim::BoardFigures> figures() override { return inner_->figures(); }

private:
    std::unique_ptr<ControllerHost> inner_;
    Sha256& digest_;
    std::array<std::uint8_t, recording::kOutputsImageCapacity> image_{};
};

struct Burnt {
    std::size_t pulses = 0;
    std::string command_hash;
    Sha256Digest outputs{};
    sim::CellReport report;
};

Burnt burn(const sim::MakeController& make, const std::string& script = "") {
    Sha256 digest;
    test::CellRig::Options options;
    options.script = script;
    options.controller = [&](const MachineConfig& machine, std::uint32_t boot_id, RetainedMemory* retained) {
        return std::make_unique<Digesting>(make(machine, boot_id, retained), digest);
    };
    test::CellRig rig(options);
    rig.make_ready();
    EXPECT_EQ(rig.open_job(test::short_job()).refusal, 0);
    EXPECT_EQ(rig.command(link::Verb::start).refusal, 0);
    EXPECT_TRUE(rig.until_state(State::marking));
    EXPECT_TRUE(rig.until([&] { return rig.state() == State::armed || rig.state() == State::fault; }));
    rig.ticks(5);
    return {rig.pulses().size(), rig.command_hash(), digest.digest(), rig.cell().report()};
}

TEST(LockStep, JobOfOneFaceGivesTheSameBytesEachTickAsOnThePc) {
    const Burnt here = burn(sim::make_local_controller);
    const Burnt there = burn(make_m7_controller(image_under_test()));
    EXPECT_GT(here.pulses, 1000U);
    EXPECT_EQ(there.pulses, here.pulses);
    EXPECT_EQ(there.command_hash, here.command_hash);
    EXPECT_EQ(there.outputs, here.outputs);
    EXPECT_EQ(there.report.command_trace_sha256, here.report.command_trace_sha256);
    EXPECT_EQ(here.report.board, "sim");
    EXPECT_FALSE(here.report.figures);
    ASSERT_TRUE(there.report.figures);
    EXPECT_EQ(there.report.board, "mps2_an500");
}

TEST(LockStep, FaultsAreTheSameToo) {
    const std::string script = "pulse 300 drive x fault 0x2310\n";
    const Burnt here = burn(sim::make_local_controller, script);
    const Burnt there = burn(make_m7_controller(image_under_test()), script);
    EXPECT_EQ(here.report.first_fault, Fault::drive_fault);
    EXPECT_EQ(there.report.first_fault, Fault::drive_fault);
    EXPECT_EQ(there.report.faults, here.report.faults);
    EXPECT_EQ(there.outputs, here.outputs);
}

link::SensorReport look(const sim::MakeController& make, const std::string& script) {
    test::CellRig::Options options;
    options.script = script;
    options.controller = make;
    test::CellRig rig(options);
    rig.make_ready();
    rig.ticks(1500);
    return rig.sensors();
}

TEST(LockStep, SensorsMeasureAsOnThePcAndSayWhatIsWrong) {
    for (const std::string script : {"", "at 0.2 sensor 2 silent\n", "at 0.2 sensor 2 crc\n"}) {
        const link::SensorReport here = look(sim::make_local_controller, script);
        const link::SensorReport there = look(make_m7_controller(image_under_test()), script);
        for (std::size_t i = kFirstTriple; i < kFirstTriple + kTripleCount; ++i) {
            const bool wrong = !script.empty() && i == 2;
            EXPECT_EQ(there.code[i] != 0, wrong) << script << i;
            EXPECT_EQ(there.count[i] > 10, !wrong) << script << i;
            EXPECT_EQ(there.value[i] > 0, !wrong) << script << i;
        }
        EXPECT_EQ(there.value, here.value) << script;
        EXPECT_EQ(there.count, here.count) << script;
        EXPECT_EQ(there.code, here.code) << script;
    }
}

TEST(LockStep, DigestSeesASingleBit) {
    // What the equality above is worth: another boot number changes one message, and so the digest.
    const auto make = [](const MachineConfig& machine, std::uint32_t boot_id, RetainedMemory* retained) {
        return sim::make_local_controller(machine, boot_id + 1, retained);
    };
    EXPECT_NE(burn(sim::make_local_controller).outputs, burn(make).outputs);
}

TEST(LockStep, FiguresCountMarkingTicksApartAndTheStackStaysWithinItsBound) {
    const sim::BoardFigures figures = *burn(make_m7_controller(image_under_test())).report.figures;
    EXPECT_GT(figures.all.ticks, figures.marking.ticks);
    EXPECT_GT(figures.marking.ticks, 100U);
    EXPECT_GE(figures.all.servo.count, figures.marking.servo.count);
    EXPECT_GE(figures.all.tick.count, figures.all.servo.count);
    EXPECT_LE(figures.all.tick.count, figures.all.servo.count + figures.all.plan.count);
    EXPECT_GT(figures.all.plan_total, 0U);
    EXPECT_LT(figures.all.servo_total, figures.all.ticks * figures.all.servo.count);
    // boards/mps2_an500/README.md states the bound.
    EXPECT_GT(figures.stack_used, 1000U);
    EXPECT_LE(figures.stack_used, 4096U);
    EXPECT_LE(figures.stack_used_at_start, 4096U);
    EXPECT_EQ(figures.stack_size, 10240U);
    RecordProperty("stack_used", static_cast<int>(figures.stack_used));
}

}  // namespace
}  // namespace sc::mps2_an500
