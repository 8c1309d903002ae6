// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "boards/sim/plant/drive_objects.hpp"
#include "boards/sim/plant/drive_servo.hpp"
#include "boards/sim/plant/drive_states.hpp"
#include "firmware/hal/io.hpp"
#include "shared/machine/machine.hpp"

/// A servo drive with its axis, at the level of CAN frames: CANopen slave (NMT, heartbeat, expedited SDO server, PDOs
/// on SYNC, EMCY), CiA 402 state machine, modes CSP and homing, position loop, friction and encoder grid. It shares no
/// code with firmware/drives. docs/drives.md has the timing and its sum.

namespace sc::sim {

/// Where the axes happen to stand when the cell is switched on: base units, off every grid.
inline constexpr std::array<double, kAxisCount> kPowerUpPosition{-0.0312347, -0.0118763, -0.0273019, 3.7131};

struct SimDriveOptions {
    std::uint8_t node = 1;
    ServoOptions servo{};
    DriveQuirks quirks{};
    bool second_bus = false;       ///< its frames carry kSecondDriveBus
    std::int64_t brake_ns = 0;     ///< the brake opens and closes so long after it was told to
    double negative_limit = -1e9;  ///< base units: true places of the limit switches
    double positive_limit = 1e9;
    double hard_stop = 0.005;       ///< base units: the axis cannot go so far beyond a limit switch
    double index_pitch = 0.005;     ///< base units between two index pulses; one lies at the reference switch
    double backlash = 0.0;          ///< base units: whole play between the motor and what it moves
    double initial_position = 0.0;  ///< base units: true place at power-up; the encoder reads 0 there
};

/// Options of an axis of the machine: grid, limits and node from `axis`, and the servo's lag computed so that
/// interpolation + bus + servo = `axis.latency_ns`. The axis stands at `initial_position` and its reference lies at
/// `axis.home_position`. `bus_ns`: delay from the sample's act time to the SYNC's arrival (0 when the board delivers at
/// t_n+1). Throws std::invalid_argument if the latency leaves less than half a millisecond for the servo.
[[nodiscard]] SimDriveOptions drive_options(const AxisConfig& axis, std::int64_t drive_cycle_ns,
                                            double initial_position, std::int64_t bus_ns = 0);

/// One drive. Time starts at 0 and only moves forward; all calls from one thread. Frames of tick n are to be given to
/// every drive, in order, at t_n+1; answers are taken with `drain` and belong to the controller's next tick.
class SimDrive {
public:
    explicit SimDrive(const SimDriveOptions& options);

    /// A frame on the bus at `t_ns` (all nodes see all frames). Steps the axis to `t_ns` first.
    void receive(const DriveFrame& on_bus, std::int64_t t_ns);
    /// Moves the axis on to `t_ns`, in internal steps of at most 50 µs; sends heartbeats and times out by itself.
    void step_to(std::int64_t t_ns);
    /// Appends the frames that the drive has sent since the last call.
    void drain(std::vector<DriveFrame>& out);

    /// Physical place of the axis at the time of the last `step_to`, base units (m or degree), as an ideal encoder
    /// without grid would read it.
    [[nodiscard]] double true_position() const noexcept { return servo_.position(); }
    [[nodiscard]] double true_velocity() const noexcept { return servo_.velocity(); }
    /// The same at a time within the last `step_to` that moved time (clamped to its ends).
    [[nodiscard]] double true_position_at(std::int64_t t_ns) const noexcept;

    /// Place of what the motor moves through the play: half the backlash behind the motor's, to the side from which it
    /// came, and anywhere between after a reversal. In the middle at power-up.
    [[nodiscard]] double load_position_at(std::int64_t t_ns) const noexcept;

    [[nodiscard]] DriveStates::State state() const noexcept { return states_.state(); }

    /// Fault injection; each lasts until it is taken back.
    void freeze_encoder(bool on) noexcept { servo_.freeze_encoder(on); }
    /// The axis runs against an obstacle at its present place, which yields by a tenth of the way asked for.
    void block(bool on) noexcept { servo_.block(on); }
    /// Sends nothing and hears nothing; the axis goes on as its own rules say.
    void go_silent(bool on) noexcept { silent_ = on; }
    /// The reference switch is not found: a homing ends with its error bit.
    void hide_reference(bool on) noexcept { reference_hidden_ = on; }
    /// Enters the fault state with this EMCY error code (fault reset clears it).
    void raise_fault(std::uint16_t error_code);
    /// Power-cycle: boots again, not homed, at the same place; the encoder reads 0.
    void restart();

private:
    struct Snapshot {
        std::int64_t t_ns = 0;
        double position = 0.0;
        double velocity = 0.0;
    };
    enum class Homing : std::uint8_t { idle, to_switch, searching, settling, attained, failed, broken_off };
    /// Where a method of homing leads: first to a switch or stop, then slowly to what it looks for.
    struct HomingWay {
        double turn = 0.0;
        double end = 0.0;
        bool direct = true;  ///< there is nothing to be met before the end
    };
    /// An RPDO that waits for its effect.
    struct Pending {
        std::int64_t at_ns = 0;
        std::array<std::vector<std::uint8_t>, 2> rpdo;
    };

    void send(std::uint32_t id, std::span<const std::uint8_t> data);
    void send_emergency(std::uint16_t code);
    void nmt(std::uint8_t command);
    void answer_sdo(const DriveFrame& frame);
    void sync();
    void send_tpdo();
    void unpack_rpdo(std::uint16_t mapping, std::span<const std::uint8_t> data);
    void take_rpdo(std::uint16_t number, std::span<const std::uint8_t> data);
    void apply(Pending& pending);
    void watch_sync();
    void run_brake();
    [[nodiscard]] HomingWay homing_way() const noexcept;
    void advance_communication();

    void actuate();
    void on_state_change(DriveStates::State before);
    void follow_mode();
    void actuate_homing(std::uint16_t controlword);
    void enter_fault(std::uint16_t code);
    void advance(std::int64_t dt_ns);
    void advance_homing(std::int64_t dt_ns);
    void watch_following();
    [[nodiscard]] double pushed(double load, double motor) const noexcept;
    [[nodiscard]] bool in_mode(std::uint32_t mode) const noexcept;
    [[nodiscard]] double following_error_counts() const noexcept;
    [[nodiscard]] std::uint16_t statusword() const noexcept;
    [[nodiscard]] double in_units(std::uint32_t counts) const noexcept;
    void refresh_objects();

    SimDriveOptions options_;
    ObjectDictionary objects_;
    DriveStates states_;
    Servo servo_;
    Trajectory demand_;
    std::vector<DriveFrame> sent_;
    std::array<std::vector<std::uint8_t>, 2> waiting_rpdo_;  ///< for the next SYNC
    std::deque<Pending> pending_;
    std::int64_t taken_ns_ = -1;     ///< when an RPDO was taken last
    std::int64_t sync_ns_ = -1;      ///< when a SYNC came last
    std::int64_t brake_at_ns_ = -1;  ///< when the brake will have moved
    bool brake_closed_ = true;
    std::uint16_t told_statusword_ = 0;
    HomingWay way_{};
    std::uint8_t nmt_state_ = 0;
    bool silent_ = false;
    bool reference_hidden_ = false;
    bool homing_bit_ = false;
    Homing homing_ = Homing::idle;
    std::uint32_t syncs_ = 0;
    std::int64_t t_ns_ = 0;
    std::int64_t boot_at_ns_ = 0;
    std::int64_t heartbeat_at_ns_ = 0;
    std::int64_t master_heard_ns_ = -1;
    std::int64_t error_since_ns_ = -1;
    std::int64_t settled_ns_ = 0;
    Snapshot before_{};
    double load_before_ = 0.0;  ///< at `before_`
    double load_ = 0.0;
};

}  // namespace sc::sim
