// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/override_keys.hpp"
#include "shared/machine/machine.hpp"

/// What a person asks for while pointing the beam, whatever it was pressed on: keyboard, a file of keys, a pendant.

namespace sc::host::cli {

enum class RecordAction : std::uint8_t { jog, step, record, skip, undo, help, quit };

struct RecordKey {
    RecordAction action = RecordAction::help;
    Axis axis = Axis::x;  ///< of a jog
    int sign = 1;
    double step = 0.0;  ///< metres: of `step`
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

inline constexpr const char* kRecordHelp =
    "arrows, or a d: x   w s: z   r f: y   1 2 3 4: steps of 1, 0.1, 0.01, 0.001 mm   Enter: record   n: skip   u: "
    "undo "
    "  q: stop, to go on later\n"
    "x grows to the left, seen from the laser";

}  // namespace sc::host::cli
