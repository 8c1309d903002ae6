// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/machine/machine.hpp"

/// What passes between the controller's pure steps and a board. No clock, no I/O, no blocking behind any of it.
///
/// Time: inputs are sampled at t_n = n · control period. The outputs of tick n act in [t_n+1, t_n+2): the set-points
/// are where the axes should be at t_n+1, the galvo frames leave at t_n+1 + k · 10 µs, laser runs carry absolute times
/// in that window. `cancel_laser` alone acts at once.

namespace sc {

inline constexpr std::size_t kGalvoFramesPerTick = 100;
inline constexpr std::size_t kLinkBytesPerTick = 1024;
inline constexpr std::size_t kDriveFramesPerTick = 24;
inline constexpr std::size_t kLaserRunsPerTick = 176;
inline constexpr std::size_t kPathPulsesPerTick = 512;
inline constexpr std::size_t kSourceBytesPerTick = 16;
inline constexpr std::size_t kSensorBytesPerTick = 32;       ///< of one bus: 230 400 baud at most
inline constexpr std::size_t kSensorTransmissionBytes = 16;  ///< longest request to a sensor

/// Set in the identifier of a frame of the second drive bus; 11 bits leave it free.
inline constexpr std::uint16_t kSecondDriveBus = 0x8000;

/// A CAN 2.0A frame on a drive bus.
struct DriveFrame {
    std::uint16_t id = 0;  ///< 11 bits, and kSecondDriveBus
    std::uint8_t size = 0;
    std::array<std::uint8_t, 8> data{};
    bool operator==(const DriveFrame&) const noexcept = default;
};

/// Digital inputs as bits; true means healthy, so a broken wire reads as the fault.
struct DigitalInputs {
    bool estop_closed = false;
    bool interlock_closed = false;
    bool laser_ready = false;  ///< source: supplies and temperature are good
    bool laser_no_alarm = false;
    bool shutter_open = false;       ///< end switch of the beam's shutter: the beam may pass
    bool shutter_closed = false;     ///< its other end switch: the beam is blocked
    bool key_setup = false;          ///< contact of the key switch; no contact, and both, mean off
    bool key_production = false;     ///< its other contact
    std::uint8_t source_status = 0;  ///< pins 11, 12, 16, 21 of a type-D source, from bit 0 on (source_status.hpp)
    bool operator==(const DigitalInputs&) const noexcept = default;
};

/// Encoders of the axes that the board reads by itself, in counts of AxisConfig::encoder_counts_per_unit from the zero
/// that the homed axis has. Axes without one stay 0.
struct EncoderInputs {
    bool valid = false;       ///< latched, all at one time
    std::int32_t age_ns = 0;  ///< how long before t_n
    std::array<std::int64_t, kAxisCount> counts{};
    bool operator==(const EncoderInputs&) const noexcept = default;
};

/// What the key allows: nothing, the guide laser alone, everything.
enum class KeyMode : std::uint8_t { off = 0, setup = 1, production = 2 };
[[nodiscard]] constexpr KeyMode key_mode(const DigitalInputs& in) noexcept {
    if (in.key_setup == in.key_production) {
        return KeyMode::off;
    }
    return in.key_production ? KeyMode::production : KeyMode::setup;
}
/// Both end switches say that the shutter is open.
[[nodiscard]] constexpr bool shutter_reads_open(const DigitalInputs& in) noexcept {
    return in.shutter_open && !in.shutter_closed;
}

struct DigitalOutputs {
    bool master_oscillator = false;  ///< MO / EE
    bool guide_laser = false;        ///< visible; joins the beam behind the shutter
    bool light_red = false;
    bool light_yellow = false;
    bool light_green = false;
    bool shutter_open = false;  ///< opens the beam's shutter; without it a spring shuts it
    bool operator==(const DigitalOutputs&) const noexcept = default;
};

/// XY2-100 status word of a healthy head whose mirrors are where they were sent: two equal bytes, each power,
/// temperature, 1, acknowledge z, acknowledge x, 1, 0, 1 from bit 7 down. A line that floats high or low is none.
inline constexpr std::uint16_t kGalvoStatusOk = 0xFDFD;
inline constexpr std::uint16_t kGalvoAckX = 0x0808;  ///< mirror x is where its last word sent it
inline constexpr std::uint16_t kGalvoAckZ = 0x1010;
/// Power, temperature and the fixed bits are right; the mirrors may be on their way.
[[nodiscard]] constexpr bool galvo_healthy(std::uint16_t status) noexcept {
    return (status >> 8U) == (status & 0xFFU) && (status | kGalvoAckX | kGalvoAckZ) == kGalvoStatusOk;
}

/// Why the guard shut the gate; a bit set, 0 = open.
enum class GuardCause : std::uint8_t {
    none = 0,
    estop = 1,
    interlock = 2,
    laser_alarm = 4,
    galvo = 8,
    shutter = 16,
    key = 32
};

/// A byte that the receiver of an RS485 bus has heard.
struct SensorByte {
    std::uint8_t data = 0;
    std::uint8_t flags = 0;    ///< 1 parity wrong, 2 no stop bit, 4 bytes before it were lost
    std::uint16_t age_us = 0;  ///< its stop bit ended so long before t_n; the times of a tick's bytes rise
    bool operator==(const SensorByte&) const noexcept = default;
};

/// What the board sends on an RS485 bus. The driver is enabled from just before the first start bit to the end of the
/// last stop bit (hardware DE), and the receiver hears nothing meanwhile. May last longer than the window.
struct SensorTransmission {
    std::array<std::uint8_t, kSensorTransmissionBytes> bytes{};
    std::uint8_t size = 0;       ///< 0: nothing
    std::uint32_t delay_ns = 0;  ///< start of the first start bit after t_n+1, less than a control period
    bool operator==(const SensorTransmission&) const noexcept = default;
};

struct ServoInputs {
    std::int64_t tick = 0;
    std::span<const std::uint8_t> link_rx;  ///< bytes that have arrived since the last tick (framed, serial carrier)
    std::span<const DriveFrame> drive_rx;   ///< frames that have arrived since the last tick
    DigitalInputs digital;
    std::uint16_t galvo_status = 0;
    std::uint8_t guard_causes = 0;  ///< what the guard has seen since the last tick, GuardCause bits
    /// From the source's serial port since the last tick: of a Raycus clocked on pins 2, 3 and 16 with pin 22 up, of a
    /// JPT 57 600 8N1.
    std::span<const std::uint8_t> source_rx{};
    EncoderInputs encoders{};
    /// Bytes of each sensor bus in (t_n−1, t_n], kSensorBytesPerTick at most.
    std::array<std::span<const SensorByte>, kSensorBuses> sensor_rx{};
};

/// One XY2-100 frame: the place asked for at the surface relative to the field's centre, and the two words on the wire.
struct GalvoFrame {
    std::int64_t x_pm = 0;  ///< along h x, before field correction
    std::int64_t z_pm = 0;
    std::uint32_t word_x = 0;  ///< 20 bits
    std::uint32_t word_z = 0;
};

/// A run of triggers: trigger k (k = 0 .. count·pick − 1 of the source's sync) leaves at
/// t0 + k·period + change·k·(k−1)/2; every `pick`-th of them, from the first, is let through the gate and makes a
/// pulse.
struct LaserRun {
    std::int64_t t0_ns = 0;         ///< absolute control time
    std::int64_t period_ns256 = 0;  ///< between pulses that pass the gate, 1/256 ns
    std::int32_t change_ns256 = 0;  ///< added to the period after each pulse, 1/256 ns
    std::uint16_t count = 0;        ///< pulses
    std::uint8_t pick = 1;          ///< the source's rate is pick times the pulse rate
    std::uint8_t power = 0;         ///< power byte
    /// The board lays the byte on its lines LaserConfig::latch_setup_ns before the latch, raises the latch so long
    /// before t0, and lets it fall after latch_width_ns. 0: the byte is in force already, no strobe. May reach into the
    /// window before by some 10 µs.
    std::uint16_t latch_ns = 0;
};

/// A pulse in the path domain: what `command_trace_sha256` is made over. Independent of latencies and of when data
/// came.
struct PathPulse {
    std::uint32_t path = 0;
    std::uint8_t pass = 0;
    std::uint8_t energy_code = 0;            ///< power byte
    std::uint32_t number = 0;                ///< in this pass, from 0
    std::int64_t s_pm = 0;                   ///< distance along the path from its first point
    std::array<std::int64_t, 3> place_pm{};  ///< commanded place of the beam in h
    std::int64_t t_ns = 0;                   ///< since the path's time law began
};

struct ServoOutputs {
    std::array<std::uint8_t, kLinkBytesPerTick> link_tx{};
    std::size_t link_tx_size = 0;
    std::array<DriveFrame, kDriveFramesPerTick> drive_tx{};
    std::size_t drive_tx_size = 0;
    AxisPositions set_point{};  ///< what was asked of the axes before rounding to counts (for the traces)
    std::array<GalvoFrame, kGalvoFramesPerTick> galvo{};
    std::array<LaserRun, kLaserRunsPerTick> laser{};
    std::size_t laser_size = 0;
    std::array<PathPulse, kPathPulsesPerTick> pulses{};
    std::size_t pulses_size = 0;
    std::array<std::uint8_t, kSourceBytesPerTick> source_tx{};  ///< to the source's serial port
    std::size_t source_tx_size = 0;
    std::array<SensorTransmission, kSensorBuses> sensor_tx{};  ///< of each sensor bus
    DigitalOutputs digital;
    bool gate_allowed = false;  ///< what frame_guard may let through in the window of this tick
    bool clear_power = false;   ///< with the window of this tick the power byte 0 is latched, unless it is already
    bool cancel_laser = false;  ///< shut the gate now and drop every queued run
    std::uint8_t state = 0;     ///< firmware/safety State, for traces
    std::uint64_t faults = 0;
};

/// Inputs of the guard, sampled at 10 kHz or more between ticks.
struct GuardInputs {
    DigitalInputs digital;
    std::uint16_t galvo_status = 0;
    bool gate_allowed = false;  ///< the last ServoOutputs' word
    LaserSource source = LaserSource::none;
};
struct GuardVeto {
    bool close_gate = true;   ///< shut the gate and drop queued runs
    std::uint8_t causes = 0;  ///< GuardCause bits
};

}  // namespace sc
