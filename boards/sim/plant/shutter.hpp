// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace sc::sim {

/// The beam's shutter: a blade on a coil and a spring, with a switch at either end. It opens while its coil is fed and
/// the hard line lets it; it blocks the light unless it is all but open. One thread.
class ShutterPlant {
public:
    static constexpr double kTravelNs = 60e6;

    /// What the coil is fed with from now on.
    void command(bool open) noexcept { wanted_ = open; }
    /// The hard line from e-stop and interlock to the coil.
    void allow(bool allowed) noexcept { allowed_ = allowed; }
    /// Stays where it is, whatever the coil says.
    void stick(bool stuck) noexcept { stuck_ = stuck; }
    /// The coil has burnt out: the spring shuts it.
    void drop(bool dropped) noexcept { dropped_ = dropped; }
    /// The plug of the switches is off: neither reads.
    void unplug(bool unplugged) noexcept { unplugged_ = unplugged; }

    /// Puts it there at once: 0 shut … 1 open.
    void put(double place) noexcept { place_ = place; }

    void step_to(std::int64_t t_ns) noexcept;
    [[nodiscard]] bool passes() const noexcept { return place_ > 0.95; }
    [[nodiscard]] bool reads_open() const noexcept { return !unplugged_ && place_ > 0.97; }
    [[nodiscard]] bool reads_closed() const noexcept { return !unplugged_ && place_ < 0.03; }

private:
    std::int64_t t_ns_ = 0;
    double place_ = 0.0;  ///< 0 shut … 1 open
    bool wanted_ = false;
    bool allowed_ = true;
    bool stuck_ = false;
    bool dropped_ = false;
    bool unplugged_ = false;
};

}  // namespace sc::sim
