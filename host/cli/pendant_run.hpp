// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/bridge/client.hpp"
#include "host/pendant/control.hpp"
#include "host/pendant/port.hpp"

/// A pendant's wishes become jogs of a cell that is idle, homed and powered.

namespace sc::host::cli {

/// One jog, as it was asked for.
struct PendantJog {
    HostTime asked;  ///< when its detents were taken
    Axis axis = Axis::x;
    double distance = 0.0;  ///< metres; C: degrees
};

struct PendantRunOptions {
    pendant::ControlOptions control{};
    Nanoseconds look{1'000'000};                        ///< how often the pendant is asked
    std::function<void(const std::string&)> on_note{};  ///< for a person
};

class PendantRun {
public:
    /// `client` is connected; both outlive this.
    PendantRun(CellClient& client, pendant::PendantPort& port, PendantRunOptions options);

    /// One look: what has come is done, time passes by `look`. False when the person has pressed Reset, or the port has
    /// ended and the cell is at rest. Throws CellFault, LinkError, Interrupted.
    bool once();
    /// Looks until `once` says no more.
    void run() {
        while (once()) {
        }
    }

    [[nodiscard]] const std::vector<PendantJog>& jogs() const { return jogs_; }
    [[nodiscard]] const pendant::PendantControl& control() const { return control_; }
    [[nodiscard]] std::uint64_t refused() const { return refused_; }  ///< jogs that the cell would not do

private:
    [[nodiscard]] pendant::CellView view() const;
    void take(const pendant::PortEvent& event);
    void carry_out(const std::vector<pendant::Wish>& wishes);
    void jog(const pendant::Wish& wish);
    void stop(const pendant::Wish& wish);
    void tell_step();
    void show();
    void note(const std::string& text) const;

    CellClient* client_;
    pendant::PendantPort* port_;
    PendantRunOptions options_;
    pendant::PendantControl control_;
    std::vector<PendantJog> jogs_;
    std::uint64_t refused_ = 0;
    bool ended_ = false;
    std::optional<pendant::Display> shown_;
    HostTime next_show_{};
    std::string told_;
};

}  // namespace sc::host::cli
