// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/cli/override_keys.hpp"
#include "host/cli/pendant_options.hpp"
#include "host/pendant/control.hpp"
#include "host/pendant/port.hpp"
#include "shared/machine/machine.hpp"

/// What a person asks for while pointing the beam, whatever it was pressed on: keyboard, a file of keys, a pendant.

namespace sc::host::cli {

enum class RecordAction : std::uint8_t { jog, step, record, skip, undo, help, quit };

struct RecordKey {
    RecordAction action = RecordAction::help;
    Axis axis = Axis::x;  ///< of a jog
    int sign = 1;
    double step = 0.0;  ///< metres: of `step`; of a jog: this far, 0: by the step that was set last
};

class RecordInput {
public:
    RecordInput() = default;
    RecordInput(const RecordInput&) = delete;
    RecordInput& operator=(const RecordInput&) = delete;
    virtual ~RecordInput() = default;
    /// Without waiting; nothing if nothing was pressed.
    [[nodiscard]] virtual std::optional<RecordKey> next() = 0;
    /// Nothing will come any more.
    [[nodiscard]] virtual bool ended() const = 0;
    /// Asked all along while a jog of this input moves: true stops it. What else came meanwhile is not kept.
    [[nodiscard]] virtual bool stops() { return false; }
    /// Where the axes are, mm, for one that shows it.
    virtual void show(const std::array<double, 3>& /*place_mm*/) {}
};

/// Arrows or a d (x), w s (z), r f (y, deeper); 1 2 3 4 for 1, 0.1, 0.01, 0.001 mm; Enter, n, u, ?, q.
class KeyboardInput final : public RecordInput {
public:
    [[nodiscard]] std::optional<RecordKey> next() override;
    [[nodiscard]] bool ended() const override { return !keys_.open(); }

private:
    TerminalKeys keys_;
};

/// Words with blanks or lines between: x+ x- y+ y- z+ z- (x+*5: five times), step=0.01 (mm), enter, skip, undo, quit. A
/// # begins a comment. Throws InputError for other words.
class ScriptInput final : public RecordInput {
public:
    explicit ScriptInput(const std::filesystem::path& file);
    [[nodiscard]] std::optional<RecordKey> next() override;
    [[nodiscard]] bool ended() const override { return at_ >= keys_.size(); }

private:
    std::vector<RecordKey> keys_;
    std::size_t at_ = 0;
};

/// A pendant: its wheel jogs, Probe-Z records, Safe-Z skips, W-HOME takes the last one back, Reset ends. Turning a
/// knob, Stop, or an unplugged pendant stops a jog.
class PendantInput final : public RecordInput {
public:
    /// `now`: the clock that the cell is served by. Both outlive this.
    PendantInput(pendant::PendantPort& port, std::function<HostTime()> now, const pendant::ControlOptions& options = {})
        : port_(&port), now_(std::move(now)), control_(options) {}
    [[nodiscard]] std::optional<RecordKey> next() override;
    [[nodiscard]] bool ended() const override { return port_->ended() && keys_.empty(); }
    [[nodiscard]] bool stops() override;
    void show(const std::array<double, 3>& place_mm) override;

private:
    bool look(bool moving);

    pendant::PendantPort* port_;
    std::function<HostTime()> now_;
    pendant::PendantControl control_;
    std::deque<RecordKey> keys_;
};

/// Two at once, as a keyboard and a pendant.
class BothInputs final : public RecordInput {
public:
    BothInputs(std::unique_ptr<RecordInput> one, std::unique_ptr<RecordInput> other)
        : one_(std::move(one)), other_(std::move(other)) {}
    [[nodiscard]] std::optional<RecordKey> next() override {
        auto key = one_->next();
        return key ? key : other_->next();
    }
    [[nodiscard]] bool ended() const override { return one_->ended() && other_->ended(); }
    [[nodiscard]] bool stops() override {
        const bool first = one_->stops();
        return other_->stops() || first;
    }
    void show(const std::array<double, 3>& place_mm) override {
        one_->show(place_mm);
        other_->show(place_mm);
    }

private:
    std::unique_ptr<RecordInput> one_;
    std::unique_ptr<RecordInput> other_;
};

/// The pendant that the options name, and the keyboard beside it where there is a terminal.
/// Throws InputError. The port is left in `port`, which must outlive the input.
[[nodiscard]] std::unique_ptr<RecordInput> pendant_input(const PendantWords& words,
                                                         std::unique_ptr<pendant::PendantPort>& port,
                                                         std::function<HostTime()> now);

inline constexpr const char* kRecordHelp =
    "arrows, or a d: x   w s: z   r f: y   1 2 3 4: steps of 1, 0.1, 0.01, 0.001 mm   Enter: record   n: skip   u: "
    "undo "
    "  q: stop, to go on later\n"
    "a pendant: its wheel jogs; Probe-Z: record   Safe-Z: skip   W-HOME: undo   Reset: stop, to go on later\n"
    "x grows to the left, seen from the laser";

}  // namespace sc::host::cli
