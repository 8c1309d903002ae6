// SPDX-License-Identifier: Apache-2.0
#include "firmware/drives/drive_node.hpp"

#include "shared/math/scalar.hpp"

namespace sc::drives {
namespace {

using axis402::PowerState;

constexpr std::int64_t kBootTicks = 1000;   ///< reset again if no boot-up came
constexpr std::int64_t kPauseTicks = 500;   ///< between a failure and the next reset
constexpr std::int64_t kStartTicks = 100;   ///< from NMT start to the first status
constexpr std::int64_t kStatusCycles = 5;   ///< missed in a row: the drive is lost
constexpr std::uint8_t kResetCycles = 25;   ///< how long a fault reset is tried
constexpr std::uint8_t kRepeatCycles = 50;  ///< a paired drive's controlword is sent again after so many
constexpr canopen::ObjectKey kOutputs{.index = 0x60FE, .sub = 1, .size = 4};  ///< bit 0: the brake closes

std::uint16_t brake_ticks(std::uint16_t ms, std::int64_t period_ns) noexcept {
    constexpr std::int64_t kNsPerMs = 1'000'000;
    return static_cast<std::uint16_t>((ms * kNsPerMs + period_ns - 1) / period_ns & 0xFFFF);
}

bool is_fault(PowerState power) noexcept {
    return power == PowerState::fault || power == PowerState::fault_reaction_active;
}

}  // namespace

[[gnu::cold]] DriveNode::DriveNode(const MachineConfig& machine, std::size_t axis, const DrivePlan& plan) noexcept
    : setup_(machine, axis, plan) {
    const AxisConfig& config = machine.axis[axis < kAxisCount ? axis : 0];
    const DriveOptions& options = plan.drive[axis < kAxisCount ? axis : 0];
    const std::int64_t period = machine.control_period_ns > 0 ? machine.control_period_ns : 1;
    const double units = axis == index(Axis::c) ? kNdegPerDegree : kPmPerMetre;
    units_per_count_ = config.counts_per_unit > 0.0 ? units / config.counts_per_unit : 1.0;
    heartbeat_ticks_ = machine.heartbeat_timeout_ns / period;
    status_every_ = options.status_every;
    status_ticks_ = kStatusCycles * static_cast<std::int64_t>(machine.drive_cycle_ticks) * status_every_;
    address_ = static_cast<std::uint16_t>(config.drive_node | (options.bus == 0 ? 0U : kSecondDriveBus));
    paired_ = options.paired;
    turn_ = static_cast<std::uint8_t>(axis % (status_every_ > 0 ? status_every_ : 1));
    release_ticks_ = brake_ticks(options.brake_release_ms, period);
    apply_ticks_ = brake_ticks(options.brake_apply_ms, period);
}

void DriveNode::enter(Phase phase, std::int64_t tick) noexcept {
    phase_ = phase;
    phase_tick_ = tick;
    nmt_due_ = phase == Phase::resetting || phase == Phase::starting;
    if (phase != Phase::operational) {
        following_ = false;
        controlword_ = axis402::kDisableVoltage;
        power_ = PowerState::unknown;
        brake_ = Brake::closed;
        unsent_cycles_ = kRepeatCycles;
    }
}

void DriveNode::boot_up(std::int64_t tick) noexcept {
    homing_.clear();
    sdo_.cancel();
    step_ = 0;
    step_begun_ = false;
    error_code_ = 0;
    reset_cycles_ = 0;
    if (service_ != nullptr) {
        service_->restarted();
    }
    enter(Phase::setup, tick);
}

void DriveNode::receive(const DriveFrame& frame, std::int64_t tick) noexcept {
    const auto base = static_cast<std::uint16_t>(frame.id - address());
    if (base == canopen::kHeartbeatBase && frame.size == 1) {
        const std::uint8_t state = frame.data[0];
        if (state == static_cast<std::uint8_t>(canopen::NmtState::boot_up)) {
            boot_up(tick);
        } else if (state == static_cast<std::uint8_t>(canopen::NmtState::operational)) {
            heard_tick_ = tick;
        }
    } else if (base == canopen::kSdoReplyBase) {
        if (service_ != nullptr && sdo_.result() != SdoClient::Result::busy) {
            service_->receive(frame);
        }
        sdo_.receive(frame);
    } else if (base == canopen::kEmcyBase) {
        const auto emergency = canopen::read_emergency(frame);
        // Code 0 says that the error is gone; what it was stays readable until the next reset.
        error_code_ = emergency && emergency->error_code != 0 ? emergency->error_code : error_code_;
    } else if (base == canopen::kTpdo1Base) {
        if (const auto status = canopen::read_tpdo1(frame)) {
            statusword_ = status->statusword;
            actual_counts_ = status->actual;
            status_tick_ = tick;
            fresh_ = true;
            new_status_ = true;
        }
    }
}

void DriveNode::update(const NodeRequest& request, std::int64_t tick, bool cycle) noexcept {
    const std::int64_t waited = tick - phase_tick_;
    switch (phase_) {
        case Phase::resetting:
            if (waited >= kBootTicks) {
                enter(Phase::resetting, tick);
            }
            break;
        case Phase::setup: run_setup(tick); break;
        case Phase::starting:
            if (new_status_) {
                enter(Phase::operational, tick);
                heard_tick_ = tick;
            } else if (waited >= kStartTicks) {
                enter(Phase::pausing, tick);
            }
            break;
        case Phase::operational:
            watch_liveness(tick);
            operate(request, tick, cycle);
            break;
        case Phase::pausing:
            if (waited >= kPauseTicks) {
                enter(Phase::resetting, tick);
            }
            break;
    }
    new_status_ = false;
}

void DriveNode::run_setup(std::int64_t tick) noexcept {
    if (!step_begun_) {
        begin_step();
        return;
    }
    bool failed = false;
    if (!step_done(failed)) {
        return;
    }
    step_begun_ = false;
    if (failed) {
        enter(Phase::pausing, tick);
    } else if (++step_ == setup_.size()) {
        enter(Phase::starting, tick);
    } else {
        begin_step();
    }
}

void DriveNode::begin_step() noexcept {
    const SetupStep step = setup_[step_];
    step_begun_ = true;
    reading_back_ = step.kind == SetupStep::Kind::expect_bits || step.kind == SetupStep::Kind::expect_value;
    if (reading_back_) {
        sdo_.read(step.key);
    } else {
        sdo_.write(step.key, step.value);
    }
}

bool DriveNode::step_done(bool& failed) noexcept {
    const SetupStep step = setup_[step_];
    switch (sdo_.result()) {
        case SdoClient::Result::busy: return false;
        case SdoClient::Result::aborted: failed = step.kind != SetupStep::Kind::write_optional; return true;
        case SdoClient::Result::idle:
        case SdoClient::Result::timed_out: failed = true; return true;
        case SdoClient::Result::done: break;
    }
    if (step.kind == SetupStep::Kind::write_checked && !reading_back_) {
        reading_back_ = true;
        sdo_.read(step.key);
        return false;
    }
    if (step.kind == SetupStep::Kind::write_checked || step.kind == SetupStep::Kind::expect_value) {
        failed = sdo_.value() != step.value;
    } else if (step.kind == SetupStep::Kind::expect_bits) {
        failed = (sdo_.value() & step.value) != step.value;
    }
    return true;
}

void DriveNode::watch_liveness(std::int64_t tick) noexcept {
    const bool silent = tick - heard_tick_ > heartbeat_ticks_ || tick - status_tick_ > status_ticks_;
    if (silent || homing_.stuck()) {
        enter(Phase::pausing, tick);
    }
}

void DriveNode::run_brake(const NodeRequest& request, std::int64_t tick) noexcept {
    if (power_ != PowerState::operation_enabled) {
        brake_ = Brake::closed;
        return;
    }
    const std::int64_t waited = tick - brake_tick_;
    const bool tell = apply_ticks_ > 0 && !homing_.active();
    const bool told = sdo_.result() != SdoClient::Result::busy;
    if (request.power && (brake_ == Brake::closed || brake_ == Brake::closing) && told) {
        brake_ = Brake::opening;
        brake_tick_ = tick;
        if (tell) {
            sdo_.write(kOutputs, 0);
        }
    } else if (!request.power && (brake_ == Brake::open || brake_ == Brake::opening) && !homing_.active() && told) {
        brake_ = Brake::closing;
        brake_tick_ = tick;
        if (tell) {
            sdo_.write(kOutputs, 1);
        }
    } else if (!told) {
        brake_tick_ = tick;
    } else if (brake_ == Brake::opening && waited >= release_ticks_) {
        brake_ = Brake::open;
    } else if (brake_ == Brake::closing && waited >= apply_ticks_) {
        brake_ = Brake::closed;
    }
}

void DriveNode::operate(const NodeRequest& request, std::int64_t tick, bool cycle) noexcept {
    if (phase_ != Phase::operational) {
        return;
    }
    if (new_status_) {
        power_ = axis402::decode(statusword_);
    }
    const bool brake = release_ticks_ + apply_ticks_ > 0;
    if (brake) {
        run_brake(request, tick);
    }
    const bool released = !brake || brake_ == Brake::open;
    homing_.step({.wanted = request.home && (released || homing_.active()),
                  .power = power_,
                  .statusword = statusword_,
                  .new_status = new_status_},
                 sdo_);
    // The caller learns of it with this tick's outcome and starts its set-point at `actual` in the next.
    const bool announced = following_;
    following_ = enabled() && released && !homing_.active() && !request.home && (following_ || request.may_follow);
    if (request.reset && power_ == PowerState::fault && reset_cycles_ == 0) {
        reset_cycles_ = 1;
        error_code_ = 0;
    }
    if (cycle) {
        // The word of a paired drive goes by itself: none is skipped.
        if (!paired_ || controlword_ == sent_controlword_) {
            controlword_ = command(request);
        }
        unsent_cycles_ = static_cast<std::uint8_t>(unsent_cycles_ + (unsent_cycles_ < kRepeatCycles ? 1 : 0));
        choose_target(request, announced && following_);
    }
}

std::uint16_t DriveNode::command(const NodeRequest& request) noexcept {
    if (power_ == PowerState::fault) {
        return fault_command();
    }
    reset_cycles_ = 0;
    const bool stopping = power_ == PowerState::operation_enabled || power_ == PowerState::quick_stop_active;
    if (request.quick_stop && stopping) {
        return axis402::kQuickStop;
    }
    const bool held = apply_ticks_ > 0 && power_ == PowerState::operation_enabled && brake_ != Brake::closed;
    const std::uint16_t word = axis402::next_controlword(power_, (request.power || held) && !request.quick_stop);
    const bool homing = word == axis402::kEnableOperation && homing_.start_bit();
    return homing ? static_cast<std::uint16_t>(word | axis402::kHomingStart) : word;
}

std::uint16_t DriveNode::fault_command() noexcept {
    if (reset_cycles_ == 0 || reset_cycles_ > kResetCycles) {
        reset_cycles_ = 0;
        return axis402::kDisableVoltage;
    }
    // The drive wants to see an edge: a word without the bit goes out first.
    return reset_cycles_++ == 1 ? axis402::kDisableVoltage : axis402::kFaultReset;
}

void DriveNode::choose_target(const NodeRequest& request, bool follow) noexcept {
    if (follow) {
        target_counts_ = round_to_i32(nearest_double(request.target) / units_per_count_);
    } else if (power_ != PowerState::operation_enabled || homing_.active()) {
        target_counts_ = actual_counts_;
    }
}

std::optional<DriveFrame> DriveNode::nmt_frame(std::int64_t cycle) noexcept {
    const bool start = phase_ == Phase::starting;
    if (!nmt_due_ || (start && status_every_ > 1 && cycle % status_every_ != turn_)) {
        return std::nullopt;
    }
    nmt_due_ = false;
    return on_bus(canopen::nmt(start ? canopen::NmtCommand::start : canopen::NmtCommand::reset_node, node()));
}

std::optional<DriveFrame> DriveNode::sdo_frame(std::int64_t tick) noexcept {
    const bool may_talk = phase_ == Phase::setup || phase_ == Phase::operational;
    if (!may_talk) {
        return std::nullopt;
    }
    std::optional<DriveFrame> frame = sdo_.poll(node(), tick);
    if (!frame && service_ != nullptr && phase_ == Phase::operational && sdo_.result() != SdoClient::Result::busy) {
        frame = service_->poll(node(), tick);
    }
    return frame ? on_bus(*frame) : frame;
}

std::optional<DriveFrame> DriveNode::rpdo_frame() const noexcept {
    if (phase_ != Phase::operational || paired_) {
        return std::nullopt;
    }
    return canopen::rpdo1(address_, controlword_, target_counts_);
}

bool DriveNode::controlword_due() const noexcept {
    const bool wanted = controlword_ != sent_controlword_ || unsent_cycles_ >= kRepeatCycles;
    return paired_ && phase_ == Phase::operational && wanted;
}

DriveFrame DriveNode::controlword_frame() noexcept {
    sent_controlword_ = controlword_;
    unsent_cycles_ = 0;
    return canopen::rpdo2(address_, controlword_);
}

DriveFrame DriveNode::on_bus(DriveFrame frame) const noexcept {
    frame.id = static_cast<std::uint16_t>(frame.id | bus_bit());
    return frame;
}

bool DriveNode::take_fresh() noexcept {
    stale_cycles_ = fresh_ ? std::uint8_t{0} : static_cast<std::uint8_t>(stale_cycles_ + (stale_cycles_ < 255 ? 1 : 0));
    fresh_ = false;
    return stale_cycles_ < status_every_;
}

bool DriveNode::fault() const noexcept { return is_fault(power_); }

bool DriveNode::tells_fault(const DriveFrame& frame) const noexcept {
    if (frame.id == canopen::kTpdo1Base + address()) {
        const auto status = canopen::read_tpdo1(frame);
        return status && is_fault(axis402::decode(status->statusword));
    }
    if (frame.id == canopen::kEmcyBase + address()) {
        const auto emergency = canopen::read_emergency(frame);
        return emergency && emergency->error_code != 0;
    }
    return false;
}

std::optional<std::int64_t> DriveNode::measured(const DriveFrame& frame) const noexcept {
    if (frame.id != canopen::kTpdo1Base + address()) {
        return std::nullopt;
    }
    const auto status = canopen::read_tpdo1(frame);
    if (!status) {
        return std::nullopt;
    }
    return static_cast<std::int64_t>(static_cast<double>(status->actual) * units_per_count_);
}

std::int64_t DriveNode::actual() const noexcept {
    // Up to 2^31 counts of at most 1e9 units each stay far inside ±9.2e18 and are exact for every usual grid.
    return static_cast<std::int64_t>(static_cast<double>(actual_counts_) * units_per_count_);
}

}  // namespace sc::drives
