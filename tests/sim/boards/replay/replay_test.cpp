// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <functional>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <stdlib.h>

#include "boards/replay/log_file.hpp"
#include "boards/replay/replayer.hpp"
#include "boards/replay/state_text.hpp"
#include "firmware/recording/log_writer.hpp"
#include "tests/sim/firmware/controller/cell_rig.hpp"

namespace sc::replay {
namespace {

namespace fs = std::filesystem;
using recording::LogEnd;

class Folder {
public:
    Folder() {
        std::string pattern = (fs::temp_directory_path() / "scribecell-XXXXXX").string();
        EXPECT_NE(::mkdtemp(pattern.data()), nullptr);
        path_ = pattern;
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder() { fs::remove_all(path_); }
    [[nodiscard]] fs::path log() const { return path_ / "inputs.rec"; }

private:
    fs::path path_;
};

struct Recorded {
    std::vector<std::uint8_t> log;
    std::string command_hash;
    std::size_t pulses = 0;
    std::optional<std::int64_t> fault_tick;
};

/// The short job to its end, or to the fault that the script brings and a while on.
Recorded record_job(const std::string& script) {
    const Folder folder;
    test::CellRig::Options options;
    options.script = script;
    options.record = folder.log();
    test::CellRig rig(options);
    rig.make_ready();
    EXPECT_EQ(rig.open_job(test::short_job()).refusal, 0);
    EXPECT_EQ(rig.command(link::Verb::start).refusal, 0);
    Recorded recorded;
    EXPECT_TRUE(rig.until([&] {
        if (rig.cell().faults() != 0 && !recorded.fault_tick) {
            recorded.fault_tick = rig.cell().now_ns() / 1'000'000 - 1;
        }
        return recorded.fault_tick || (rig.status().flags & link::kFlagJobDone) != 0;
    }));
    rig.ticks(100);
    rig.cell().close();
    recorded.log = read_log_file(folder.log());
    recorded.command_hash = rig.command_hash();
    recorded.pulses = rig.path_pulses().size();
    return recorded;
}

const Recorded& whole_job() {
    static const Recorded recorded = record_job("");
    return recorded;
}

ReplayResult replay(std::span<const std::uint8_t> log, const ReplayOptions& options = {}) {
    return std::make_unique<Replayer>(log, options)->run();
}

TEST(Replay, GivesTheRecordedOutputsWhateverTheMemoryHeldBefore) {
    const ReplayResult plain = replay(whole_job().log);
    EXPECT_TRUE(plain.equal());
    EXPECT_EQ(plain.end, LogEnd::closed);
    EXPECT_EQ(plain.first_tick, 0);
    EXPECT_EQ(plain.pulses, whole_job().pulses);
    EXPECT_EQ(plain.command_trace_sha256, whole_job().command_hash);
    EXPECT_EQ(plain.first_fault.fault, Fault::none);
    for (const std::uint8_t paint : {std::uint8_t{0x00}, std::uint8_t{0xA5}, std::uint8_t{0xFF}}) {
        const ReplayResult painted = replay(whole_job().log, {.until = {}, .paint = paint});
        EXPECT_TRUE(painted.equal()) << int{paint};
        EXPECT_EQ(painted.outputs_sha256, plain.outputs_sha256);
        EXPECT_EQ(painted.inner_sha256, plain.inner_sha256);
    }
}

TEST(Replay, StopsWhereItIsToldAndTellsTheState) {
    const auto replayer = std::make_unique<Replayer>(whole_job().log, ReplayOptions{.until = 40, .paint = {}});
    const ReplayResult result = replayer->run();
    EXPECT_TRUE(result.equal());
    EXPECT_EQ(result.last_tick, 40);
    EXPECT_EQ(result.end, LogEnd::none);
    const nlohmann::ordered_json state =
        state_json(replayer->controller(), replayer->inputs(), *replayer->outputs(), reference_machine());
    EXPECT_EQ(state["tick"], 40);
    EXPECT_EQ(state["state"], "boot");
    EXPECT_EQ(state["inputs"]["estop_closed"], true);
    EXPECT_NE(lines_of(state).find("\n  x:\n    set_point: "), std::string::npos);
}

class ReplayOfAFault : public testing::TestWithParam<std::pair<const char*, Fault>> {};

TEST_P(ReplayOfAFault, FindsItAtTheSameTick) {
    const Recorded recorded = record_job(GetParam().first);
    ASSERT_TRUE(recorded.fault_tick);
    const ReplayResult result = replay(recorded.log);
    EXPECT_TRUE(result.equal());
    EXPECT_EQ(result.first_fault.fault, GetParam().second);
    EXPECT_EQ(result.first_fault.tick, *recorded.fault_tick);
    EXPECT_EQ(result.first_fault.state, State::marking);
    const nlohmann::ordered_json json = fault_json(result.first_fault);
    EXPECT_EQ(json["code"], static_cast<int>(GetParam().second));
    EXPECT_EQ(json["state_before"], "marking");
}

INSTANTIATE_TEST_SUITE_P(Scripts, ReplayOfAFault,
                         testing::Values(std::pair{"pulse 900 interlock open", Fault::interlock_open},
                                         std::pair{"pulse 900 drive x fault 0x2310", Fault::drive_fault}));

/// The log with one tick's inputs changed, its checksums right and its digests as they were recorded.
std::vector<std::uint8_t> with_changed_tick(std::span<const std::uint8_t> log, std::int64_t tick,
                                            const std::function<void(recording::StoredInputs&)>& change) {
    recording::LogReader reader(log);
    const auto writer = std::make_unique<recording::LogWriter>();
    const auto logged = std::make_unique<recording::LoggedTick>();
    std::vector<std::uint8_t> changed;
    const auto add = [&changed](std::span<const std::uint8_t> bytes) {
        changed.insert(changed.end(), bytes.begin(), bytes.end());
    };
    add(writer->begin(reader.header(), log.size() + 10'000));
    while (reader.next(*logged)) {
        if (logged->stored.inputs.tick == tick) {
            change(logged->stored);
        }
        add(writer->add(logged->stored.inputs, logged->digest));
    }
    add(writer->flush());
    add(writer->close());
    return changed;
}

TEST(Replay, NamesTheFirstTickThatIsNotAsRecorded) {
    EXPECT_TRUE(replay(with_changed_tick(whole_job().log, 5, [](auto&) {})).equal()) << "the rewriting itself is right";
    const auto tick = static_cast<std::int64_t>(replay(whole_job().log).ticks) - 900;
    const std::vector<std::uint8_t> changed = with_changed_tick(
        whole_job().log, tick, [](recording::StoredInputs& in) { in.inputs.digital.interlock_closed = false; });
    const ReplayResult result = replay(changed);
    EXPECT_FALSE(result.equal());
    ASSERT_TRUE(result.difference);
    EXPECT_EQ(result.difference->tick, tick);
    EXPECT_EQ(result.last_tick, tick) << "it stops there";
    EXPECT_EQ(result.difference->recorded.faults, 0U);
    EXPECT_EQ(result.difference->replayed.faults, fault_bit(Fault::interlock_open));
    EXPECT_EQ(result.difference->replayed.state, static_cast<std::uint8_t>(State::fault));
    const auto& parts = result.difference->parts;
    EXPECT_NE(std::find(parts.begin(), parts.end(), recording::OutputPart::lines), parts.end());
}

TEST(Replay, NeverCallsAChangedLogEqual) {
    const Folder folder;
    test::CellRig::Options options;
    options.record = folder.log();
    test::CellRig rig(options);
    rig.ticks(40);
    rig.cell().close();
    std::vector<std::uint8_t> log = read_log_file(folder.log());
    ASSERT_TRUE(replay(log).equal());
    ASSERT_LT(log.size(), 3000U);
    for (std::size_t byte = 0; byte < log.size(); ++byte) {
        const auto bit = static_cast<std::uint8_t>(1U << (byte % 8));
        log[byte] = static_cast<std::uint8_t>(log[byte] ^ bit);
        const auto replayer = std::make_unique<Replayer>(log, ReplayOptions{});
        const ReplayResult result = replayer->run();
        EXPECT_FALSE(result.equal()) << byte;
        EXPECT_FALSE(recording::readable(result.end)) << byte;
        log[byte] = static_cast<std::uint8_t>(log[byte] ^ bit);
    }
}

TEST(Replay, OfATornLogGoesAsFarAsItIsWhole) {
    const std::span<const std::uint8_t> log = whole_job().log;
    const ReplayResult result = replay(log.first(log.size() - 1));
    EXPECT_TRUE(result.equal());
    EXPECT_EQ(result.end, LogEnd::torn);
    const ReplayResult half = replay(log.first(log.size() / 2));
    EXPECT_EQ(half.end, LogEnd::torn);
    EXPECT_EQ(half.ticks % 1000, 0U) << "whole seconds";
    EXPECT_GT(half.ticks, 2000U);
}

TEST(Recording, EndsAtItsLimitAndTheCellGoesOn) {
    const Folder folder;
    sim::CellOptions options;
    options.world = fs::path(SC_SOURCE_DIR) / "boards/sim/world/default/world.toml";
    options.record = folder.log();
    options.record_limit_bytes = recording::LogWriter::kLeastLimit;
    sim::SimCell cell(options);
    for (int i = 0; i < 12'000; ++i) {
        cell.tick();
    }
    ASSERT_NE(cell.record(), nullptr);
    EXPECT_TRUE(cell.record()->full());
    cell.close();
    const std::vector<std::uint8_t> log = read_log_file(folder.log());
    EXPECT_LE(log.size(), recording::LogWriter::kLeastLimit);
    const ReplayResult result = replay(log);
    EXPECT_TRUE(result.equal());
    EXPECT_EQ(result.end, LogEnd::full);
    EXPECT_EQ(result.ticks, cell.record()->ticks());
    options.record_limit_bytes = recording::LogWriter::kLeastLimit - 1;
    EXPECT_THROW(sim::SimCell{options}, std::invalid_argument);
    options.record = "/nowhere/inputs.rec";
    options.record_limit_bytes = 1'000'000;
    EXPECT_THROW(sim::SimCell{options}, std::system_error);
}

TEST(Recording, ADiskThatRefusesEndsTheRecordingNotTheCell) {
    sim::CellOptions options;
    options.world = fs::path(SC_SOURCE_DIR) / "boards/sim/world/default/world.toml";
    options.record = "/dev/full";
    sim::SimCell cell(options);
    for (int i = 0; i < 3000; ++i) {
        cell.tick();
    }
    EXPECT_EQ(cell.state(), State::disabled);
    EXPECT_NE(cell.record()->error(), "");
}

}  // namespace
}  // namespace sc::replay
