// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "firmware/controller/black_box.hpp"
#include "firmware/controller/fired_watch.hpp"
#include "firmware/controller/job_runner.hpp"
#include "firmware/controller/map_intake.hpp"
#include "firmware/drives/drive_master.hpp"
#include "firmware/hal/io.hpp"
#include "firmware/hal/retained.hpp"
#include "firmware/laser/head_proof.hpp"
#include "firmware/laser/mopa_serial.hpp"
#include "firmware/laser/power_port.hpp"
#include "firmware/link/endpoint.hpp"
#include "firmware/safety/laser_rule.hpp"
#include "firmware/safety/shutter_watch.hpp"
#include "firmware/safety/supervisor.hpp"
#include "firmware/safety/watch.hpp"
#include "firmware/sensors/seating.hpp"
#include "firmware/sensors/sensor_hub.hpp"
#include "firmware/store/parameter_store.hpp"
#include "shared/machine/machine.hpp"

namespace sc {

/// The whole controller of a cell: two pure steps that a board calls. No clock, no I/O, no heap, no blocking. About 1
/// MB; give it static storage.
///
/// Order within a tick: link in, events, faults, motion, watches, gate, drives, link out. The set-points of this tick
/// are watched in this tick; the drives' answers are those of the last.
class Controller {
public:
    /// `boot_id` should differ at each start. `retained` outlives the controller; null: the board keeps nothing without
    /// power. `drives`: how the drives are spoken to, as the board's machine file has it.
    Controller(const MachineConfig& machine, std::uint32_t boot_id, RetainedMemory* retained = nullptr,
               const DrivePlan& drives = kPlainDrives) noexcept;

    /// Uses a drive's SDO channel while the master does not. Outlives the controller.
    void serve_drive(std::size_t axis, drives::SdoService* service) noexcept { drives_.attach(axis, service); }
    /// Share of the drive bus, or why it is refused: then no drive will ever be present.
    [[nodiscard]] const std::expected<drives::BusBudget, Refusal>& drive_budget() const noexcept {
        return drives_.budget();
    }

    /// Where parameters are kept without power, and the generation of those that `machine` came from (0: the board's
    /// own). Once, before the first step.
    void keep_parameters_in(ParameterMemory* memory, std::uint32_t generation) noexcept {
        store_.keep_in(memory);
        generation_in_force_ = generation;
    }

    /// From now on host messages count only if they are sealed (firmware/link/seal_gate.hpp). Once, before the first
    /// step; never called, nothing of it runs.
    void fit_key(const link::SealSecret& secret) noexcept { link_.fit_key(secret); }

    /// Each control period, hard. Bounded by the frames, bytes and pulses of one tick.
    void servo_step(const ServoInputs& in, ServoOutputs& out) noexcept;
    /// Look-ahead planning: up to `units` elements of work. Pre-emptible by servo_step on boards that make it so; what
    /// it does takes effect at a tick that was fixed when the task began. A board that gives fewer than
    /// motion::kUnitsPerTick a tick is late. With a key it checks seals first.
    void plan_step(std::uint32_t units) noexcept {
        link_.check_seals();
        runner_.work(units);
    }

    [[nodiscard]] State state() const noexcept { return supervisor_.state(); }
    [[nodiscard]] std::uint64_t faults() const noexcept { return supervisor_.faults(); }
    [[nodiscard]] const safety::FaultRecord& first_fault() const noexcept { return supervisor_.first_fault(); }
    [[nodiscard]] const link::Endpoint& link() const noexcept { return link_; }
    // What follows is for a look inside at rest (replay, tests); nothing decides by it.
    [[nodiscard]] const JobRunner& runner() const noexcept { return runner_; }
    [[nodiscard]] const drives::Outcome& drives_seen() const noexcept { return drives_seen_; }
    [[nodiscard]] const safety::MoSequencer& master_oscillator() const noexcept { return mo_; }
    [[nodiscard]] const sensors::SensorHub& sensor_hub() const noexcept { return hub_; }
    [[nodiscard]] std::uint32_t pulses_total() const noexcept { return pulses_total_; }
    [[nodiscard]] std::uint32_t starvations() const noexcept { return starvations_; }

private:
    struct Verdict {
        Refusal refusal = Refusal::none;
        std::int64_t detail = 0;
    };

    void take_events(const ServoInputs& in) noexcept;
    void take_command(const link::Command& command, const ServoInputs& in) noexcept;
    void answer(std::uint32_t sequence, const Verdict& verdict) noexcept;
    [[nodiscard]] Verdict decide(const link::Command& command, const ServoInputs& in) noexcept;
    [[nodiscard]] Verdict post(safety::Event event) noexcept;
    [[nodiscard]] Verdict arm(const ServoInputs& in) noexcept;
    [[nodiscard]] Verdict preview(const ServoInputs& in) noexcept;
    [[nodiscard]] Verdict ask_width(const link::Command& command) noexcept;
    void speak_to_source(const ServoInputs& in, ServoOutputs& out) noexcept;
    [[nodiscard]] Verdict start(safety::Event event, bool preview) noexcept;
    [[nodiscard]] bool laser_healthy(const DigitalInputs& in) const noexcept;
    [[nodiscard]] Verdict jog(const link::Command& command) noexcept;
    [[nodiscard]] Verdict abort() noexcept;
    [[nodiscard]] Verdict open(const link::JobOpen& job) noexcept;
    [[nodiscard]] Verdict open_midst(const link::JobResume& job) noexcept;
    void tell_position(std::uint32_t token) noexcept;
    [[nodiscard]] Verdict set_override(const link::Command& command) noexcept;
    [[nodiscard]] LimitedBy limited_by() const noexcept;
    [[nodiscard]] Verdict set_compensation(const link::SetCompensation& message) noexcept;
    [[nodiscard]] Verdict set_galvo_field(const link::SetGalvoField& message) noexcept;
    [[nodiscard]] Verdict set_power_curve(const link::SetPowerCurve& message) noexcept;
    [[nodiscard]] Verdict set_galvo_lag(const link::SetGalvoLag& message) noexcept;

    [[nodiscard]] bool geometry_may_change() const noexcept;
    [[nodiscard]] Verdict take_map_chunk(const link::MapChunk& message) noexcept;
    [[nodiscard]] Verdict set_map(const link::SetMap& message) noexcept;
    [[nodiscard]] Verdict store_parameters(const link::StoreParameters& message) noexcept;
    void keep_parameters() noexcept;
    [[nodiscard]] link::Parameters parameters(std::uint16_t offset) const noexcept;

    void sense(const ServoInputs& in, ServoOutputs& out) noexcept;
    [[nodiscard]] Verdict set_surface(const link::SetSurface& message) noexcept;
    [[nodiscard]] Verdict check_seating(const link::CheckSeating& message, std::int64_t tick) noexcept;
    [[nodiscard]] Verdict guide(const link::Command& command, const ServoInputs& in) noexcept;
    /// Whether key and enclosure let the guide laser be on.
    [[nodiscard]] static Refusal guide_allowed(const DigitalInputs& in) noexcept;
    [[nodiscard]] Verdict fire_in_turn(const link::Command& command) noexcept;
    void report_sensors(std::int64_t tick) noexcept;
    void watch_surface(std::int64_t tick) noexcept;

    void watch_inputs(const ServoInputs& in) noexcept;
    void watch_beam(const ServoInputs& in) noexcept;
    void watch_source(const ServoInputs& in) noexcept;
    void watch_drives(const ServoInputs& in) noexcept;
    void watch_link(const ServoInputs& in) noexcept;
    void measure_axes(const ServoInputs& in) noexcept;
    void watch_set_points(const AxisPositions& before, std::int64_t tick) noexcept;
    void trip(Fault fault, std::uint8_t axis, std::int64_t tick) noexcept;
    [[nodiscard]] std::uint64_t present_faults(const ServoInputs& in) const noexcept;
    void try_reset(const ServoInputs& in) noexcept;

    void advance_states() noexcept;
    void advance_job() noexcept;
    void advance_preview() noexcept;
    [[nodiscard]] bool drop_refused() noexcept;
    void end_job() noexcept;
    void advance_stop() noexcept;
    void drop_aborted() noexcept;
    void close_job() noexcept;
    void gate(const ServoInputs& in, ServoOutputs& out) noexcept;
    void latch_power(ServoOutputs& out) noexcept;
    void lines(ServoOutputs& out) noexcept;
    void drive(const ServoInputs& in, ServoOutputs& out) noexcept;
    void follow_drives() noexcept;
    void report(const ServoInputs& in, ServoOutputs& out) noexcept;
    [[nodiscard]] std::uint8_t status_flags(const ServoInputs& in, const ServoOutputs& out) const noexcept;
    void note(link::BlackboxKind kind, std::uint8_t a = 0, std::uint16_t b = 0) noexcept;
    void note_starved() noexcept;
    [[nodiscard]] link::BlackboxSample black_box_sample(const ServoInputs& in, const ServoOutputs& out) const noexcept;
    void record(const ServoInputs& in, const ServoOutputs& out) noexcept;
    void send_more(const ServoInputs& in, ServoOutputs& out) noexcept;
    [[nodiscard]] link::TelemetryValues telemetry(const ServoInputs& in, const ServoOutputs& out) const noexcept;
    [[nodiscard]] bool homed() const noexcept;

    MachineConfig machine_;
    link::Endpoint link_;
    drives::DriveMaster drives_;
    safety::Supervisor supervisor_;
    safety::MoSequencer mo_;
    safety::ShutterWatch shutter_;
    bool shutter_open_ = false;  ///< the command that is in force
    safety::FollowingWatch following_;
    laser::HeadProof head_;
    laser::PowerPort power_;
    laser::MopaSerial mopa_;
    std::uint32_t width_sequence_ = 0;
    sensors::SensorHub hub_;
    sensors::SeatingCheck seating_;
    std::uint32_t seating_sequence_ = 0;
    bool seating_failed_ = false;    ///< the last check of the seat did
    std::int64_t warned_ticks_ = 0;  ///< of arming, with the emission warning on
    store::ParameterStore store_;
    std::uint32_t store_sequence_ = 0;
    std::uint32_t generation_in_force_ = 0;
    JobRunner runner_;
    std::variant<MapIntake, GalvoField> intake_;  ///< what comes in pieces over the link, one thing at a time
    std::size_t field_numbers_ = 0;               ///< of a GalvoField that have come
    std::uint32_t map_crc_ = 0;                   ///< of the map in force

    drives::Outcome drives_seen_{};
    std::uint8_t home_stage_ = 0;  ///< 0: y, 1: x and z, 2: C
    bool job_open_ = false;
    bool job_done_ = false;
    bool job_started_ = false;
    bool job_burns_ = false;  ///< it is no preview
    JobStart job_start_;
    FiredWatch fired_;
    RetainedMemory* retained_;
    std::optional<JobRecord> retained_record_;  ///< from before this start
    safety::Event stop_reason_ = safety::Event::hold;
    std::int64_t silent_since_ = 0;
    bool reset_wanted_ = false;
    std::uint32_t reset_sequence_ = 0;
    std::int64_t reset_deadline_ = 0;
    bool reset_drives_ = false;
    bool cancel_ = false;
    bool pulses_before_ = false;  ///< the last tick's outputs held pulses
    std::uint32_t pulses_total_ = 0;
    std::uint32_t starvations_ = 0;
    std::int64_t stale_ticks_ = 0;
    safety::Finding suspicion_;  ///< of the following watch, until it is known what it is
    std::int64_t suspicion_tick_ = 0;
    bool pointing_ = false;  ///< the guide laser is on for a person
    State reported_state_ = State::boot;
    std::int64_t report_tick_ = -1'000'000;
    BlackBox black_box_;
    std::int64_t tick_ = 0;
    State recorded_state_ = State::boot;
    std::uint32_t recorded_bad_ = 0;
    bool silent_ = true;  ///< the host, as last noted
};

}  // namespace sc
