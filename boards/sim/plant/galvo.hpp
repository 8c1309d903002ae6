// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "boards/sim/world/world_spec.hpp"
#include "firmware/hal/io.hpp"
#include "shared/machine/machine.hpp"

namespace sc::sim {

/// What a head takes from one 20-bit XY2-100 word: the 16-bit position, or nothing when the control code is not 001 or
/// the parity is odd.
[[nodiscard]] std::optional<std::uint16_t> decode_xy2_100(std::uint32_t word) noexcept;
/// The same of the 18-bit format: control bit 1, eighteen data bits, odd parity.
[[nodiscard]] std::optional<std::uint32_t> decode_xy2_100_18(std::uint32_t word) noexcept;

/// Deflection of both mirrors, as the place at the focal plane that they ask for.
struct Deflection {
    std::array<double, 2> place{};  ///< metres, (x, z)
    std::array<double, 2> speed{};  ///< metres / s
};
/// Deflection between two states a frame apart, `fraction` 0..1 of the frame from `from` (cubic, exact to nanometres).
[[nodiscard]] std::array<double, 2> between(const Deflection& from, const Deflection& to, double fraction,
                                            double frame_seconds) noexcept;

/// Two-mirror head on an XY2-100 line. Each mirror is a pure delay and a second-order servo. The command is held for a
/// frame, so that a ramp given frame by frame is followed at exactly `GalvoTruth::tracking` behind the frames' times:
/// half a frame of hold + delay + 2·damping / ωn. One thread; a frame costs some 10 ns, at rest 2 ns.
class GalvoPlant {
public:
    /// Throws std::invalid_argument when hold and servo alone exceed the tracking time.
    GalvoPlant(const MachineConfig& machine, const GalvoTruth& truth);

    /// One frame leaves now; the mirrors move on to the end of its period. A bad word leaves its mirror's command as it
    /// was and counts as dropped.
    void play(std::uint32_t word_x, std::uint32_t word_z);
    [[nodiscard]] const Deflection& state() const noexcept { return state_; }
    [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_; }
    /// Pure delay that makes the tracking time right, seconds.
    [[nodiscard]] double delay() const noexcept { return delay_; }

    /// Fault: the servo loses its supply; the mirrors stop where they are and the status word tells.
    void fail(bool on) noexcept { failed_ = on; }
    /// Fault: no head is there, and the status line stays at this word whatever is sent; nullopt: the head is back.
    void unplug(std::optional<std::uint16_t> line) noexcept { line_status_ = line; }
    /// Power, temperature and fixed bits, and of each mirror whether it is within `GalvoTruth::ack_limit` of the last
    /// word's place. Two equal bytes.
    [[nodiscard]] std::uint16_t status() const noexcept;

private:
    using Pair = std::array<double, 2>;
    /// Exact step of the servo towards a constant command: (error, speed) after = matrix · before.
    struct Step {
        double ee = 1.0, ev = 0.0, ve = 0.0, vv = 1.0;
    };
    [[nodiscard]] static Step step_of(const GalvoTruth& truth, double seconds);
    void take(std::size_t mirror, std::uint32_t word);
    void move(const Pair& command, const Step& step);
    [[nodiscard]] bool settled() const noexcept;

    GalvoConvention convention_;
    GalvoWord format_;
    double metres_per_count_;
    double ack_limit_;
    double delay_ = 0.0;
    Step early_;              ///< until the command of this frame's delay arrives
    Step late_;               ///< from then to the end of the frame
    std::vector<Pair> line_;  ///< commands on their way, newest at newest_
    std::size_t newest_ = 0;
    std::array<std::uint32_t, 2> word_{};  ///< last word seen of each mirror
    Pair command_{};
    std::size_t frames_unchanged_ = 0;
    bool failed_ = false;
    std::optional<std::uint16_t> line_status_;
    Deflection state_;
    std::uint64_t dropped_ = 0;
};

}  // namespace sc::sim
