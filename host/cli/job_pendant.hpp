// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "host/cli/pendant_options.hpp"
#include "host/pendant/control.hpp"
#include "host/pendant/port.hpp"

namespace sc::host::cli {

/// A pendant beside a job that runs: its feed keys, Start/Pause and Stop. The wheel moves nothing then, and pulling the
/// plug changes nothing.
class JobPendant {
public:
    /// Throws InputError.
    JobPendant(const PendantWords& words, std::function<void(const std::string&)> on_note);

    void look(HostTime now, std::uint8_t override_percent);
    /// Each of what was pressed, once.
    [[nodiscard]] std::optional<std::uint8_t> take_override();
    [[nodiscard]] bool take_pause();
    /// From the first press of Stop on.
    [[nodiscard]] bool stopped() const { return stopped_; }

private:
    std::unique_ptr<pendant::PendantPort> port_;
    std::function<void(const std::string&)> on_note_;
    pendant::PendantControl control_;
    std::optional<std::uint8_t> override_;
    bool pause_ = false;
    bool paused_ = false;
    bool stopped_ = false;
};

}  // namespace sc::host::cli
