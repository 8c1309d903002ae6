// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "boards/replay/inner_hash.hpp"
#include "boards/replay/painted_controller.hpp"
#include "firmware/recording/digest.hpp"
#include "firmware/recording/log_reader.hpp"
#include "firmware/safety/supervisor.hpp"
#include "shared/crypto/aes128.hpp"
#include "shared/hash/sha256.hpp"

namespace sc::replay {

struct ReplayOptions {
    std::optional<std::int64_t> until;  ///< last tick to run
    std::optional<std::uint8_t> paint;  ///< pattern of the memory, see PaintedController
    std::optional<crypto::Key> key{};   ///< of a controller that took sealed commands
    /// Called after each tick that is equal, and after the one that differs.
    std::function<void(const ServoInputs&, const ServoOutputs&)> on_tick{};
};

/// The first tick whose outputs are not those of the log.
struct Difference {
    std::int64_t tick = 0;
    recording::OutputsDigest recorded;
    recording::OutputsDigest replayed;
    /// Parts whose 8-bit checks differ. May be empty once in 256: the CRC-32 over all alone is sure.
    std::vector<recording::OutputPart> parts;
};

struct ReplayResult {
    std::uint64_t ticks = 0;  ///< run, with the one that differs
    std::int64_t first_tick = 0;
    std::int64_t last_tick = 0;
    recording::LogEnd end = recording::LogEnd::none;  ///< none: stopped at `until` or at a difference
    std::size_t end_offset = 0;                       ///< in the file, where a chunk that is not good begins
    std::optional<Difference> difference;
    std::uint64_t pulses = 0;
    std::string command_trace_sha256;  ///< over the pulses of the ticks run
    std::string outputs_sha256;        ///< over the packed outputs of the ticks run
    std::string inner_sha256;          ///< over what was not yet rounded (inner_hash.hpp); the log does not hold it
    safety::FaultRecord first_fault;   ///< the first since the start of the log or the last reset
    double wall_seconds = 0.0;
    double cell_seconds = 0.0;

    /// There were ticks, all were readable, and all gave the same outputs.
    [[nodiscard]] bool equal() const noexcept {
        return ticks > 0 && !difference && (end == recording::LogEnd::none || recording::readable(end));
    }
};

/// Runs a controller with the inputs of a log and compares what it answers. One thread, no clock but for the speed.
class Replayer {
public:
    /// `log` stays the caller's. A log that cannot be used at all shows in `problem()`.
    Replayer(std::span<const std::uint8_t> log, const ReplayOptions& options);

    /// LogEnd::none if the log can be run.
    [[nodiscard]] recording::LogEnd problem() const noexcept { return problem_; }
    /// The log was made with a key, and the options' is not that one. It must not be run then.
    [[nodiscard]] bool lacks_key() const noexcept;
    [[nodiscard]] const recording::LogReader& reader() const noexcept { return reader_; }
    /// Once. Without a usable log there is nothing to run.
    ReplayResult run();
    /// As it stands after `run`; only with a usable log.
    [[nodiscard]] const Controller& controller() const { return controller_->controller(); }
    /// Inputs of the last tick.
    [[nodiscard]] const ServoInputs& inputs() const noexcept { return tick_.stored.inputs; }
    [[nodiscard]] const ServoOutputs* outputs() const noexcept { return outputs_; }

private:
    void run_tick(ReplayResult& result);

    ReplayOptions options_;
    recording::LogReader reader_;
    recording::LogEnd problem_;
    std::optional<PaintedController> controller_;
    recording::LoggedTick tick_;
    recording::OutputsDigester digester_;
    const ServoOutputs* outputs_ = nullptr;
    Sha256 commands_;
    Sha256 images_;
    InnerHash inner_;
};

}  // namespace sc::replay
