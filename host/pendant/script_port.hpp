// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/pendant/port.hpp"

namespace sc::host::pendant {

/// A pendant that a file plays: reports by the clock of the cell. A line an event, `#` begins a comment:
///
///     MS plug | unplug
///     MS axis off|x|y|z|a|b|c
///     MS feed 0.001|0.01|0.1|1|60%|100%|lead
///     MS wheel N          detents in one report, -128..127
///     MS press KEY [KEY]  until `release`; names: docs/pendant.md
///     MS release
///     MS raw HH HH ...    bytes of a report as they are
///
/// MS: milliseconds since the first look, with places behind the point, never less than in the line before.
class ScriptPort final : public PendantPort {
public:
    struct Event {
        Nanoseconds at{0};
        PortEvent event;
    };

    /// Throws InputError with file, line and value.
    explicit ScriptPort(const std::filesystem::path& file);
    explicit ScriptPort(std::vector<Event> events) : events_(std::move(events)) {}

    [[nodiscard]] std::optional<PortEvent> next(HostTime now) override;
    void show(const Display& display) override { shown_ = display; }
    [[nodiscard]] bool ended() const override { return at_ >= events_.size(); }
    [[nodiscard]] bool real() const override { return false; }
    [[nodiscard]] const std::optional<Display>& shown() const { return shown_; }

private:
    std::vector<Event> events_;
    std::size_t at_ = 0;
    std::optional<HostTime> begun_;
    std::optional<Display> shown_;
};

/// The text of such a file. `name`: for errors.
[[nodiscard]] std::vector<ScriptPort::Event> parse_script(const std::string& text, const std::string& name);

}  // namespace sc::host::pendant
