// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "boards/sim/plant/drive.hpp"
#include "boards/sim/plant/fault_player.hpp"
#include "boards/sim/plant/galvo.hpp"
#include "boards/sim/plant/laser.hpp"
#include "boards/sim/plant/mopa_source.hpp"
#include "boards/sim/plant/shutter.hpp"
#include "boards/sim/plant/source_pins.hpp"
#include "boards/sim/sensors/sensor_plant.hpp"
#include "boards/sim/world/world.hpp"
#include "firmware/hal/io.hpp"
#include "shared/trace/trace.hpp"

namespace sc::sim {

/// The guard as the board calls it (firmware/safety frame_guard).
using GuardFunction = GuardVeto (*)(const GuardInputs&) noexcept;
/// Takes every lit pulse, in order of time.
using PulseSink = std::function<void(const trace::PulseRecord&)>;

/// What the beam's outputs have been, for whoever must show that they have not. Times in ns.
struct BeamCounters {
    std::int64_t master_oscillator_ns = 0;  ///< on
    std::int64_t gate_ns = 0;               ///< allowed by the tick
    std::int64_t shutter_ns = 0;            ///< not shut
    std::int64_t guide_ns = 0;              ///< guide laser on
    std::uint64_t shuttered = 0;            ///< pulses that the shutter kept back
};

/// Lines between controller and source as they stand at the plant, for whoever judges them.
enum class Pin : std::uint8_t {
    gate,               ///< 1 open: allowed by the tick and by the guard, and not cancelled
    trigger,            ///< an edge that passed the gate; no level
    master_oscillator,  ///< 1 on
    guide_laser,        ///< 1 on
    shutter_coil,       ///< 1 fed
    beam_way,           ///< 1: the blade lets light pass
};
/// Takes levels at each guard period and each tick, changed or not, in order of time but for gate and trigger (some
/// µs).
using PinSink = std::function<void(std::int64_t t_ns, Pin pin, bool level)>;

/// Takes the place of the guide laser's spot: control time, and the record's places as of a pulse.
using GuideSink = std::function<void(const trace::PulseRecord&)>;

/// Hard line from e-stop and interlock to the light itself: no firmware in it. design.md allows 1 µs.
inline constexpr std::int64_t kHardCutNs = 800;
/// From the guard's sample to the shut gate.
inline constexpr std::int64_t kGuardActNs = 5'000;
/// From the start of a tick that cancels the laser to the shut gate.
inline constexpr std::int64_t kCancelActNs = 10'000;

/// What the cell's drives have of their own, by axis.
struct PlantDrives {
    std::array<DriveQuirks, kAxisCount> quirks{};
    std::array<bool, kAxisCount> second_bus{};
};

/// All that is outside the controller: drives and axes, head, laser, I/O lines, the true world, and the script of
/// faults. Plays the outputs of tick n in [t_n+1, t_n+2), as firmware/hal/io.hpp says. For tick n, at t_n:
///
///     sample(inputs) · the controller's step · accept(n, its outputs) · play(n, outputs of tick n − 1)
///
/// One thread; heap use only in vectors that keep their size. A dark tick with mirrors at rest takes some microseconds.
class CellPlant {
public:
    /// `world` must outlive this. Throws std::invalid_argument for periods that do not divide each other.
    /// `drives`: what differs from plain ones.
    CellPlant(const MachineConfig& machine, const World& world, std::vector<FaultEvent> script,
              GuardFunction guard_function, const PlantDrives& drives = {});

    /// Inputs at t_n, all but the link's. The spans stay valid until the next call.
    void sample(ServoInputs& inputs);
    /// Outputs of tick `tick`, just computed at its beginning: queues laser runs, which carry their own times; a
    /// cancel acts now.
    void accept(std::int64_t tick, const ServoOutputs& outputs);
    /// Lets the cell live from t_tick to t_tick+1. `acting`: outputs of the tick before, nullptr at the first.
    void play(std::int64_t tick, const ServoOutputs* acting, const PulseSink& sink);
    [[nodiscard]] const MopaSource& mopa() const noexcept { return mopa_; }
    [[nodiscard]] ShutterPlant& shutter() noexcept { return shutter_; }
    [[nodiscard]] SensorPlant& sensors() noexcept { return sensors_; }
    /// Where the guide laser shines, each guard period while it is on.
    void watch_guide(GuideSink sink) { guide_sink_ = std::move(sink); }

    void watch_pins(PinSink sink);
    /// One more event of the script.
    void inject(FaultEvent event) { faults_.add(std::move(event)); }

    /// Encoders on their grids, pm / ndeg.
    [[nodiscard]] AxisPositions encoders() const;
    [[nodiscard]] bool link_connected() const noexcept { return link_connected_; }
    [[nodiscard]] std::uint64_t pulses() const noexcept { return pulses_; }
    /// Time of the last light, −1 when there was none.
    [[nodiscard]] std::int64_t last_pulse_ns() const noexcept { return last_pulse_ns_; }
    [[nodiscard]] const LaserCounters& laser_counters() const noexcept { return laser_.counters(); }
    [[nodiscard]] const BeamCounters& beam_counters() const noexcept { return beam_; }
    [[nodiscard]] std::uint64_t galvo_words_dropped() const noexcept { return galvo_.dropped(); }
    [[nodiscard]] FaultPlayer& faults() noexcept { return faults_; }
    [[nodiscard]] const std::vector<FaultRecord>& fault_records() const noexcept { return faults_.records(); }
    [[nodiscard]] const SimDrive& drive(Axis axis) const { return drives_[index(axis)]; }

private:
    void begin_window(std::int64_t t_ns, const ServoOutputs* acting);
    void read_lines();
    void read_encoders(EncoderInputs& encoders, std::int64_t t_ns) const;
    void shine_guide(std::int64_t t_ns, const ServoOutputs* acting);
    void show(SourceTrouble trouble);
    void show_pins(std::int64_t t_ns, const ServoOutputs* acting);
    void guard(std::int64_t t_ns, bool gate_allowed);
    void move(std::int64_t t_ns, std::size_t first_frame, const ServoOutputs* acting);
    void fire(std::int64_t begin_ns, std::int64_t end_ns, const PulseSink& sink);
    void light(const LaserPulse& pulse, std::int64_t begin_ns, const PulseSink& sink);
    [[nodiscard]] bool marks(const LaserPulse& pulse, const Spot& spot) const;
    [[nodiscard]] trace::PulseRecord record_of(const LaserPulse& pulse, std::int64_t begin_ns) const;
    void run_timed_events(std::int64_t t_ns);
    void apply(const FaultEvent& event, std::int64_t t_ns);
    void apply_to_laser(FaultAction action);
    void apply_to_beam(FaultAction action);
    void apply_to_drive(const FaultEvent& event);
    void apply_to_sensor(const FaultEvent& event);
    void apply_lines(std::int64_t t_ns);

    MachineConfig machine_;
    const World* world_;
    GuardFunction guard_;
    FaultPlayer faults_;
    std::vector<SimDrive> drives_;
    std::vector<DriveFrame> drive_rx_;
    std::vector<DriveFrame> drive_sent_;
    GalvoPlant galvo_;
    std::vector<Deflection> deflections_;  ///< at the frame boundaries of the present guard period
    LaserPlant laser_;
    MopaSource mopa_;
    std::vector<std::uint8_t> source_rx_;
    SensorPlant sensors_;
    std::array<std::vector<SensorByte>, kSensorBuses> sensor_rx_;
    ShutterPlant shutter_;
    BeamCounters beam_;
    GuideSink guide_sink_;
    PinSink pin_sink_;
    std::int64_t cancelled_until_ns_ = 0;  ///< the gate stays shut
    DigitalInputs lines_;
    std::uint8_t guard_causes_ = 0;
    bool link_connected_ = true;
    std::uint64_t pulses_ = 0;
    std::int64_t last_pulse_ns_ = -1;
};

}  // namespace sc::sim
