// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "firmware/controller/axis_follower.hpp"
#include "firmware/hal/io.hpp"
#include "firmware/laser/field_map.hpp"
#include "firmware/laser/pulse_placer.hpp"
#include "firmware/motion/axis_geometry.hpp"
#include "firmware/motion/move.hpp"
#include "firmware/motion/path_motion.hpp"
#include "firmware/motion/stage_curve.hpp"
#include "firmware/sensors/surface.hpp"
#include "shared/codes/codes.hpp"
#include "shared/machine/galvo_lag.hpp"
#include "shared/machine/machine.hpp"
#include "shared/machine/power_curve.hpp"
#include "shared/path/item.hpp"
#include "shared/path/item_queue.hpp"

namespace sc {

/// An item that cannot be run, and why.
struct ItemRefusal {
    Refusal refusal = Refusal::none;
    std::uint32_t item = 0;
    std::uint8_t axis = 0;
    std::int64_t value = 0;  ///< wire units of the axis
};

/// Where in a job to begin: at an item, with C at an angle, and with so much of its path done.
struct JobStart {
    std::uint32_t first = 0;  ///< 0: at its beginning, and the rest does not matter
    std::int32_t c = 0;       ///< wire units
    FiredPosition done;       ///< pulses of the first path that are not fired again
};

/// Runs a job item by item: turns, the dark way to each path, the path itself with its pulses, and single moves (jogs).
/// Knows where the beam is commanded to be at any time. Servo context, once a tick; the planner's work() is called from
/// the plan step.
class JobRunner {
public:
    enum class Phase : std::uint8_t {
        idle,
        next_item,
        turn_retract,
        turn_c,
        open_path,      ///< points until the start of the run-in is known
        travel_across,  ///< x and z at the retracted y
        travel_in,
        jump,  ///< mirrors to the path's start, or to zero
        settle,
        await_plan,
        path,
        look_across,  ///< x and z at the retracted y, to where a look begins
        look_in,
        look_settle,  ///< until the shift of y is gone
        look_stand,   ///< until the sensor has seen the place where the axes stand
        look_on,      ///< along the line
        end_retract,
        jog,
        done,
    };

    explicit JobRunner(const MachineConfig& machine) noexcept;

    /// The axes stand here (set-points). Only while nothing moves.
    void stand_at(const AxisPositions& set_point) noexcept;
    /// New geometry; the set-points stay, the place in h changes. Only while nothing moves.
    void set_compensation(const Compensation& compensation) noexcept;
    /// Another axis map, which check_map has passed with this cost: motion in h keeps so far below the axes' limits
    /// that the set-points keep them. Only while nothing moves.
    void set_map(const AxisMap& map, const MapCost& cost) noexcept;

    /// Feed override, 10..200 % of the programmed speed of paths (the controller has checked it); 100 at the start.
    /// Kept from job to job. Any time.
    void set_feed_override(std::uint8_t percent) noexcept;
    [[nodiscard]] std::uint8_t feed_override_percent() const noexcept { return feed_override_percent_; }

    /// New field correction, in place of the compensation's matrix for the galvo; drop takes it away.
    void set_galvo_field(const GalvoField& field) noexcept { field_.set(field); }
    void drop_galvo_field() noexcept { field_.drop(); }

    /// How the mirrors follow; a sound lag.
    void set_galvo_lag(const GalvoLag& lag) noexcept;
    /// Where the axes were measured, for mirrors that follow them. Before `step`, in order of time.
    void take_axes(const AxisSample& sample) noexcept { follower_.take(sample); }

    /// Power over the power byte as measured; a sound one.
    void set_power_curve(const PowerCurve& curve) noexcept { curve_ = curve; }

    /// What the Y sensor is used for; false, with nothing changed, for settings that make no sense. Only while nothing
    /// moves.
    [[nodiscard]] bool set_surface(const sensors::SurfaceSettings& settings) noexcept;
    /// The Y sensor's reading, before `step`.
    void see(const sensors::Sample& sample) noexcept { sample_ = sample; }
    [[nodiscard]] const sensors::Surface& surface() const noexcept { return surface_; }

    /// `preview`: no pulses, and paths no faster than the guide laser may go.
    /// Begun in its midst, the first path is run from its beginning, dark up to the first pulse that is not yet done:
    /// so each of the others is where, and as, it would have been. If it begins with looks, paths behind them are
    /// passed over up to the one that `done` names: the surface must be looked at anew.
    void start_job(bool preview = false, const JobStart& start = {}) noexcept;
    /// One bounded move of one axis; `speed` in base units / s. The caller has checked its reach.
    void start_jog(Axis axis, double distance, double speed) noexcept;
    /// Jerk-limited stop of whatever moves. `at_rest()` tells when.
    void request_stop() noexcept;
    /// From rest after request_stop (or starvation): go on.
    void resume() noexcept;
    /// Forget the job. Only at rest.
    void drop() noexcept;

    /// Set-points, galvo frames and, if `may_mark`, pulses of this tick. False: the planner was late.
    [[nodiscard]] bool step(std::int64_t tick, ItemQueue& items, bool may_mark, ServoOutputs& out) noexcept;
    void work(std::uint32_t units) noexcept { motion_.work(units); }

    [[nodiscard]] bool at_rest() const noexcept { return at_rest_; }
    /// On a path, from the start of its run-in to the last pulse's light.
    [[nodiscard]] bool on_path() const noexcept { return phase_ == Phase::path && !stopping_; }
    /// In a preview: the beam's place lies between the path's first and last pulse.
    [[nodiscard]] bool on_line() const noexcept { return on_line_; }
    [[nodiscard]] bool job_done() const noexcept { return phase_ == Phase::done; }
    [[nodiscard]] bool idle() const noexcept { return phase_ == Phase::idle; }
    /// Stopped by itself for want of points; and whether enough has come to go on.
    [[nodiscard]] bool starved() const noexcept { return phase_ == Phase::path && motion_.starved(); }
    [[nodiscard]] bool can_continue() const noexcept { return phase_ == Phase::path && motion_.can_continue(); }
    /// Running, nothing to do, and nothing in the queue.
    [[nodiscard]] bool waiting_for_items() const noexcept { return waiting_; }
    [[nodiscard]] const ItemRefusal& refusal() const noexcept { return refusal_; }
    [[nodiscard]] LimitedBy limited_by() const noexcept { return limited_by_; }

    /// Items taken from the queue, items planned, items whose last pulse has left.
    [[nodiscard]] std::uint32_t planned() const noexcept { return planned_; }
    [[nodiscard]] std::uint32_t fired() const noexcept { return fired_; }
    [[nodiscard]] const FiredPosition& fired_position() const noexcept { return fired_position_; }
    [[nodiscard]] const AxisPositions& set_point() const noexcept { return set_point_; }
    /// Path speed at the tick's first pulse, m/s (0 without pulses).
    [[nodiscard]] double pulse_speed() const noexcept { return pulse_speed_; }

    [[nodiscard]] const motion::AxisGeometry& geometry() const noexcept { return geometry_; }
    [[nodiscard]] Phase phase() const noexcept { return phase_; }
    [[nodiscard]] const motion::PathMotion& motion() const noexcept { return motion_; }
    /// Settings of the present path, or the last.
    [[nodiscard]] const PathBegin& path() const noexcept { return path_; }

private:
    static constexpr std::size_t kX = index(Axis::x);
    static constexpr std::size_t kY = index(Axis::y);
    static constexpr std::size_t kZ = index(Axis::z);
    static constexpr std::size_t kC = index(Axis::c);

    [[nodiscard]] static double metres(std::int32_t wire) noexcept {
        return static_cast<double>(wire) / kWireUnitsPerMetre;
    }
    void set_retreat() noexcept;
    void set_limits() noexcept;
    [[nodiscard]] bool surface_is_there() noexcept;
    void follow_surface() noexcept;
    void watch_beam(const motion::Segment& segment, double t) noexcept;
    void begin_look(const Look& look) noexcept;
    void stand_to_look(bool begins) noexcept;
    void look_step() noexcept;
    void refuse_surface(sensors::Surface::Verdict verdict, std::uint32_t item, double y) noexcept;
    [[nodiscard]] bool pass_over(const Item& item) noexcept;
    void take_item(ItemQueue& items) noexcept;
    void begin_turn(const Turn& turn) noexcept;
    void begin_path(const PathBegin& begin) noexcept;
    void feed(ItemQueue& items) noexcept;
    void check_place(const motion::Place& place, std::uint32_t item) noexcept;
    void add_point(const PathPoint& point, std::uint32_t item) noexcept;
    void add_arc(const PathArc& arc, std::uint32_t item) noexcept;
    [[nodiscard]] bool add_mark(const Item& front, std::uint32_t item) noexcept;
    void add_light(const PathLight& light, std::uint32_t item) noexcept;
    void add_curve(const StageCurve& curve, std::uint32_t item) noexcept;
    void add_knot(const StageKnot& knot, std::uint32_t item) noexcept;
    void check_reach(const motion::Place& place, double distance, std::uint32_t item) noexcept;
    void check_way(const motion::Place& to, double length, std::uint32_t item) noexcept;
    void check_end() noexcept;
    void refuse(Refusal refusal, std::uint32_t item, Axis axis, double value) noexcept;
    [[nodiscard]] bool in_travel(const motion::Place& place, std::uint32_t item) noexcept;
    void begin_stage_move(const motion::Place& to, Phase phase) noexcept;
    void begin_travel() noexcept;
    void begin_jump() noexcept;
    void move_step(ServoOutputs& out) noexcept;
    void move_done() noexcept;
    void path_step(bool may_mark, ServoOutputs& out) noexcept;
    void stage_step(const motion::Segment& segment, double t) noexcept;
    /// By the mirrors, alone or with the stage.
    [[nodiscard]] bool by_mirrors() const noexcept { return path_.actuator != Actuator::axes; }
    /// Where the stage stands when the path begins.
    [[nodiscard]] motion::Place stand() const noexcept;
    /// The place of the axes that the mirrors' share of a path is about.
    [[nodiscard]] motion::Place stage_place(const motion::StageCurve::Point& point) const noexcept {
        return {point[kX], point[kY], point[kZ], place_[kC]};
    }
    /// Ticks by which the stage is behind its set-points when the mirrors are where their frames say.
    [[nodiscard]] double stage_late(std::size_t axis) const noexcept { return stage_late_[axis]; }
    void place_pulses(std::int64_t t_ns, bool may_mark, ServoOutputs& out) noexcept;
    void trace_line(double t) noexcept;
    /// Distance along the path of what is to be done next.
    [[nodiscard]] double next_distance() const noexcept { return preview_ ? traced_ : placer_.next_distance(motion_); }
    void finish_path() noexcept;
    /// The override in force on this path, as the pulses allow it.
    [[nodiscard]] double override_share() noexcept;
    void galvo_path(motion::Segment segment, double t, ServoOutputs& out) noexcept;
    void galvo_jump(double t, ServoOutputs& out) noexcept;
    void galvo_still(ServoOutputs& out) noexcept;
    /// Frames that take up what the axes are off their path; false: the mirrors have nothing to take up.
    [[nodiscard]] bool follow_axes(ServoOutputs& out) noexcept;
    [[nodiscard]] laser::FieldPatch field_patch(const motion::Place& at) const noexcept {
        return field_.patch(at[index(Axis::x)], at[index(Axis::z)], at[index(Axis::y)]);
    }
    [[nodiscard]] std::int64_t light_lag_ns() const noexcept;
    [[nodiscard]] double seconds(std::int64_t ticks) const noexcept;

    MachineConfig machine_;
    double y_retracted_;  ///< as the machine has it, for set-points; machine_ holds the place in h
    motion::AxisGeometry geometry_;
    motion::AxisLimits stage_limits_;
    motion::AxisLimits path_limits_;  ///< of the stage on a path: C stands
    motion::AxisLimits galvo_limits_;
    motion::PathMotion motion_;
    laser::FieldMap field_;
    GalvoLead lead_;
    std::int64_t mirror_lag_ns_ = 0;  ///< of the mirrors behind their frames, less what the lead makes up for
    std::array<double, 3> stage_late_{};
    motion::StageCurve stage_;
    motion::StageFollower stage_follower_;
    motion::StageHistory history_;
    AxisFollower follower_;
    laser::PulsePlacer placer_;
    PowerCurve curve_;
    MapCost map_cost_;
    sensors::Surface surface_;
    sensors::Sample sample_;
    motion::Place look_{};         ///< where the look goes
    motion::Place first_point_{};  ///< of the path
    motion::Place beam_{};         ///< commanded place of the beam on the path
    bool beam_is_lit_ = false;     ///< a pulse may be placed there
    motion::Move move_;

    Phase phase_ = Phase::idle;
    bool at_rest_ = true;
    bool stopping_ = false;
    bool waiting_ = false;
    bool path_closed_ = false;  ///< the path's end has come
    motion::Place last_point_{};
    motion::Place before_{};   ///< the one before it
    motion::Place arrives_{};  ///< the way that an arc arrives there
    bool by_arc_ = false;
    bool has_point_ = false;
    std::uint32_t last_point_item_ = 0;
    bool has_way_ = false;
    bool dark_ = false;          ///< the path is, behind the last point
    double stage_lag_ = 0.0;     ///< path distance by which the stage can be behind its curve
    double taken_length_ = 0.0;  ///< of the points' polyline so far, a longest run-in before it
    bool end_checked_ = false;   ///< and lies within the travel, with its run-out
    std::int64_t tick_ = 0;
    std::int64_t phase_tick_ = 0;  ///< tick at which the phase's time began
    bool rate_held_ = false;       ///< by the source's greatest rate
    std::int64_t rest_ticks_ = 0;  ///< ticks since the stage last moved
    motion::Place place_{};        ///< commanded place of the axes in h, and C
    motion::Place target_{};       ///< where the present stage move was to end
    double field_x_ = 0.0;         ///< commanded galvo place relative to the axes, m
    double field_z_ = 0.0;
    double field_depth_ = 0.0;  ///< of the surface nearer to the head than the anchor's focal plane, m
    AxisPositions set_point_{};
    PathBegin path_;
    std::uint32_t items_taken_ = 0;
    std::uint32_t path_end_item_ = 0;
    std::uint32_t planned_ = 0;
    std::uint32_t fired_ = 0;
    FiredPosition fired_position_;
    FiredPosition done_;        ///< where a job goes on in its midst
    bool resumes_ = false;      ///< and has not come to a path yet
    bool passes_over_ = false;  ///< after looks: paths are passed over up to the one of `done_`
    bool passes_path_ = false;  ///< within one of them
    ItemRefusal refusal_;
    LimitedBy limited_by_ = LimitedBy::none;
    double pulse_speed_ = 0.0;
    double move_speed_ = 0.0;  ///< of a jog or a look, m/s or rad/s
    bool preview_ = false;
    bool on_line_ = false;
    double traced_ = 0.0;  ///< distance along the path up to which the guide laser has gone
    std::uint8_t feed_override_percent_ = 100;
    motion::Cursor cursor_;
};

}  // namespace sc
