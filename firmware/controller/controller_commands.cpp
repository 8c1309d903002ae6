// SPDX-License-Identifier: Apache-2.0
#include <span>
#include <variant>

#include "firmware/controller/controller.hpp"
#include "shared/machine/source_status.hpp"
#include "shared/math/scalar.hpp"

namespace sc {
namespace {

using safety::Event;

constexpr std::int64_t kResetPatienceTicks = 500;
constexpr double kJogLargest = 0.010;     ///< m in one step
constexpr double kJogLargestTurn = 10.0;  ///< degrees
constexpr double kJogFastest = 0.05;      ///< m/s
constexpr double kJogFastestTurn = 20.0;  ///< °/s

bool finite(double v) noexcept { return v >= -1e300 && v <= 1e300; }

}  // namespace

/// Answers a request, and notes it if it was refused.
void Controller::answer(std::uint32_t sequence, const Verdict& verdict) noexcept {
    link_.reply(sequence, verdict.refusal, verdict.detail);
    if (verdict.refusal != Refusal::none) {
        note(link::BlackboxKind::request, 0, static_cast<std::uint16_t>(verdict.refusal));
    }
}

void Controller::take_command(const link::Command& command, const ServoInputs& in) noexcept {
    const auto verb = static_cast<link::Verb>(command.verb);
    Verdict verdict;
    bool later = false;  // the answer
    if (verb == link::Verb::reset_fault && state() == State::fault) {
        reset_wanted_ = true;
        reset_drives_ = true;
        reset_sequence_ = command.sequence;
        reset_deadline_ = in.tick + kResetPatienceTicks;
        later = true;
    } else if (verb == link::Verb::set_pulse_width) {
        verdict = ask_width(command);
        later = verdict.refusal == Refusal::none;
    } else {
        verdict = decide(command, in);
    }
    if (!later) {
        link_.reply(command.sequence, verdict.refusal, verdict.detail);
    }
    note(link::BlackboxKind::command, command.verb, static_cast<std::uint16_t>(verdict.refusal));
}

void Controller::take_events(const ServoInputs& in) noexcept {
    link::LinkEvent event;
    while (link_.poll(event)) {
        switch (event.kind) {
            case link::LinkEvent::Kind::none: break;
            case link::LinkEvent::Kind::session_resumed: note(link::BlackboxKind::link_back, 1); break;
            case link::LinkEvent::Kind::session_open:
                note(link::BlackboxKind::link_back);
                // Nothing of another host's session goes on by itself.
                seating_failed_ = false;
                (void)abort();
                break;
            case link::LinkEvent::Kind::command: take_command(event.command, in); break;
            case link::LinkEvent::Kind::job_open: answer(event.job_open.sequence, open(event.job_open)); break;
            case link::LinkEvent::Kind::job_resume:
                answer(event.job_resume.sequence, open_midst(event.job_resume));
                break;
            case link::LinkEvent::Kind::position_request: tell_position(event.position_request.token); break;
            case link::LinkEvent::Kind::galvo_field:
                answer(event.galvo_field.sequence, set_galvo_field(event.galvo_field));
                break;
            case link::LinkEvent::Kind::power_curve:
                answer(event.power_curve.sequence, set_power_curve(event.power_curve));
                break;
            case link::LinkEvent::Kind::galvo_lag:
                answer(event.galvo_lag.sequence, set_galvo_lag(event.galvo_lag));
                break;
            case link::LinkEvent::Kind::compensation:
                answer(event.compensation.sequence, set_compensation(event.compensation));
                break;
            case link::LinkEvent::Kind::surface: answer(event.surface.sequence, set_surface(event.surface)); break;
            case link::LinkEvent::Kind::seating:
                if (const Verdict verdict = check_seating(event.seating, in.tick); verdict.refusal != Refusal::none) {
                    answer(event.seating.sequence, verdict);
                }
                break;
            case link::LinkEvent::Kind::store_parameters:
                if (const Verdict verdict = store_parameters(event.store_parameters);
                    verdict.refusal != Refusal::none) {
                    answer(event.store_parameters.sequence, verdict);
                }
                break;
            case link::LinkEvent::Kind::sensors: report_sensors(in.tick); break;
            case link::LinkEvent::Kind::map_chunk:
                answer(event.map_chunk.sequence, take_map_chunk(event.map_chunk));
                break;
            case link::LinkEvent::Kind::set_map: answer(event.set_map.sequence, set_map(event.set_map)); break;
        }
    }
}

Controller::Verdict Controller::post(Event event) noexcept {
    if (supervisor_.post(event)) {
        return {};
    }
    return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
}

Controller::Verdict Controller::decide(const link::Command& command, const ServoInputs& in) noexcept {
    switch (static_cast<link::Verb>(command.verb)) {
        case link::Verb::enable:
            if (!in.digital.estop_closed) {
                return {Refusal::estop_open, 0};
            }
            return post(Event::enable);
        case link::Verb::disable: return post(Event::disable);
        case link::Verb::home:
            if (!runner_.at_rest()) {
                return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
            }
            home_stage_ = 0;
            return post(Event::home);
        case link::Verb::arm: return arm(in);
        case link::Verb::disarm: return post(Event::disarm);
        case link::Verb::start: return start(Event::start, false);
        case link::Verb::preview: return preview(in);
        case link::Verb::hold: {
            const Verdict verdict = post(Event::hold);
            if (verdict.refusal == Refusal::none) {
                stop_reason_ = Event::hold;
                runner_.request_stop();
            }
            return verdict;
        }
        case link::Verb::resume: {
            const Verdict verdict = post(state() == State::held_link ? Event::link_back : Event::resume);
            if (verdict.refusal == Refusal::none) {
                runner_.resume();
            }
            return verdict;
        }
        case link::Verb::abort: return abort();
        case link::Verb::reset_fault: return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
        case link::Verb::jog: return jog(command);
        case link::Verb::stop: {
            const Verdict verdict = post(Event::stop);
            if (verdict.refusal == Refusal::none) {
                runner_.request_stop();
            }
            return verdict;
        }
        case link::Verb::set_override: return set_override(command);
        case link::Verb::guide: return guide(command, in);
        case link::Verb::lasers_in_turn: return fire_in_turn(command);
        case link::Verb::set_pulse_width: break;  // answered when the source has answered
    }
    return {Refusal::unknown_command, command.verb};
}

Controller::Verdict Controller::set_override(const link::Command& command) noexcept {
    if (command.arg0 < link::kMinOverride || command.arg0 > link::kMaxOverride) {
        return {Refusal::bad_override, command.arg0};
    }
    runner_.set_feed_override(static_cast<std::uint8_t>(command.arg0));
    return {};
}

Controller::Verdict Controller::start(Event event, bool preview) noexcept {
    if (!job_open_) {
        return {Refusal::job_mismatch, 0};
    }
    if (!preview && (seating_failed_ || seating_.busy())) {
        return {Refusal::seating_not_proven, 0};
    }
    const Verdict verdict = post(event);
    if (verdict.refusal == Refusal::none) {
        job_done_ = false;
        job_started_ = true;
        job_burns_ = !preview;
        runner_.start_job(preview, job_start_);
        if (job_burns_) {
            fired_.begin(link_.job(), link_.job_items(), {job_start_.first, job_start_.done}, retained_);
        }
    }
    return verdict;
}

/// With the key at setup the enclosure may be open: that is what one looks through.
Controller::Verdict Controller::preview(const ServoInputs& in) noexcept {
    if (!supervisor_.allowed(Event::preview)) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    if (!homed()) {
        return {Refusal::not_homed, 0};
    }
    if (const Refusal refusal = guide_allowed(in.digital); refusal != Refusal::none) {
        return {refusal, 0};
    }
    if (machine_.galvo.convention == GalvoConvention::unset) {
        return {Refusal::galvo_convention_unset, 0};
    }
    return start(Event::preview, true);
}

Refusal Controller::guide_allowed(const DigitalInputs& in) noexcept {
    const KeyMode key = key_mode(in);
    if (key == KeyMode::off) {
        return Refusal::key_off;
    }
    return in.interlock_closed || key == KeyMode::setup ? Refusal::none : Refusal::interlock_open;
}

Controller::Verdict Controller::guide(const link::Command& command, const ServoInputs& in) noexcept {
    pointing_ = false;
    if (command.arg0 != 1) {
        return {};
    }
    if (!safety::pointing_state(state())) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    const Refusal refusal = guide_allowed(in.digital);
    pointing_ = refusal == Refusal::none;
    return {refusal, 0};
}

Controller::Verdict Controller::ask_width(const link::Command& command) noexcept {
    if (safety::mo_state(state())) {
        return {Refusal::pulse_width_while_armed, static_cast<std::int64_t>(state())};
    }
    if (!mopa_.speaks()) {
        return {Refusal::pulse_width_unsupported, 0};
    }
    if (mopa_.busy()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    if (command.arg0 < 1 || command.arg0 > laser::MopaSerial::kMostWidth) {
        return {Refusal::pulse_width_refused, 0};
    }
    mopa_.begin(static_cast<std::uint16_t>(command.arg0));
    width_sequence_ = command.sequence;
    return {};
}

void Controller::speak_to_source(const ServoInputs& in, ServoOutputs& out) noexcept {
    out.source_tx_size = mopa_.transmit(out.source_tx);
    switch (mopa_.step(in.source_rx)) {
        case laser::WidthAnswer::none: break;
        case laser::WidthAnswer::set: link_.reply(width_sequence_, Refusal::none, mopa_.answered()); break;
        case laser::WidthAnswer::refused:
            link_.reply(width_sequence_, Refusal::pulse_width_refused, mopa_.answered());
            break;
        case laser::WidthAnswer::silent: link_.reply(width_sequence_, Refusal::pulse_width_no_answer, 0); break;
        case laser::WidthAnswer::foreign: link_.reply(width_sequence_, Refusal::pulse_width_wrong_source, 0); break;
    }
}

Controller::Verdict Controller::arm(const ServoInputs& in) noexcept {
    if (store_.busy()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};  // parameters are being written
    }
    if (!supervisor_.allowed(Event::arm) || mopa_.busy()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    if (key_mode(in.digital) != KeyMode::production) {
        return {Refusal::key_not_production, static_cast<std::int64_t>(key_mode(in.digital))};
    }
    if (!homed()) {
        return {Refusal::not_homed, 0};
    }
    if (!in.digital.estop_closed) {
        return {Refusal::estop_open, 0};
    }
    if (!in.digital.interlock_closed) {
        return {Refusal::interlock_open, 0};
    }
    if (!laser_healthy(in.digital)) {
        return {Refusal::laser_not_ready,
                static_cast<std::int64_t>(source_state(machine_.laser.source, in.digital.source_status))};
    }
    if (machine_.galvo.convention == GalvoConvention::unset) {
        return {Refusal::galvo_convention_unset, 0};
    }
    if (seating_failed_ || seating_.busy()) {
        return {Refusal::seating_not_proven, 0};
    }
    return post(Event::arm);
}

Controller::Verdict Controller::jog(const link::Command& command) noexcept {
    if (!supervisor_.allowed(Event::jog) || !runner_.at_rest()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    if (command.arg0 < 0 || command.arg0 >= static_cast<std::int32_t>(kAxisCount)) {
        return {Refusal::unknown_command, command.arg0};
    }
    if (!homed()) {
        return {Refusal::not_homed, 0};
    }
    const auto axis = static_cast<Axis>(command.arg0);
    const bool turn = axis == Axis::c;
    const double distance = static_cast<double>(command.arg1) / (turn ? kWireUnitsPerDegree : kWireUnitsPerMetre);
    const double speed = static_cast<double>(command.arg2) * (turn ? 1e-3 : 1e-6);
    if (!(speed > 0.0 && speed <= (turn ? kJogFastestTurn : kJogFastest))) {
        return {Refusal::bad_speed, command.arg0};
    }
    AxisPositions end = runner_.set_point();
    end[index(axis)] += rounded(distance * (turn ? kNdegPerDegree : kPmPerMetre));
    const double retreat = machine_.y_retracted.si() - 1e-6 + 2.0 * runner_.geometry().map_shift(index(Axis::y));
    const bool retracted = static_cast<double>(end[index(Axis::y)]) / kPmPerMetre >= retreat;
    if (absolute(distance) > (turn ? kJogLargestTurn : kJogLargest) || (turn && !retracted) ||
        safety::check_travel(machine_, end) || safety::check_keep_out(machine_, runner_.set_point(), end)) {
        return {Refusal::jog_out_of_range, command.arg0};
    }
    runner_.start_jog(axis, distance, speed);
    return post(Event::jog);
}

Controller::Verdict Controller::abort() noexcept {
    const bool at_rest = state() == State::held || state() == State::held_link;
    const Verdict verdict = post(Event::abort);
    if (verdict.refusal == Refusal::none) {
        stop_reason_ = Event::abort;
        if (at_rest) {
            close_job();
            runner_.drop();
        } else {
            runner_.request_stop();
        }
    }
    return verdict;
}

Controller::Verdict Controller::open(const link::JobOpen& job) noexcept {
    if ((state() != State::idle && state() != State::armed) || !runner_.at_rest()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    link_.open_job(job.job, job.items);
    note(link::BlackboxKind::job_opened, 0, static_cast<std::uint16_t>(job.job & 0xFFFFU));
    job_open_ = true;
    job_done_ = job_started_ = false;
    job_start_ = {};
    runner_.drop();
    return {};
}

Controller::Verdict Controller::open_midst(const link::JobResume& job) noexcept {
    if ((state() != State::idle && state() != State::armed) || !runner_.at_rest()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    if (job.first >= job.items) {
        return {Refusal::too_many_points, job.first};
    }
    link_.resume_job(job);
    note(link::BlackboxKind::job_opened, 1, static_cast<std::uint16_t>(job.job & 0xFFFFU));
    job_open_ = true;
    job_done_ = job_started_ = false;
    job_start_ = {job.first, job.c, {job.path, job.pass, job.first, job.pulse}};
    runner_.drop();
    return {};
}

void Controller::tell_position(std::uint32_t token) noexcept {
    link::Position position;
    position.token = token;
    const bool known = fired_.record().job != 0;
    const JobRecord record = known ? fired_.record() : retained_record_.value_or(JobRecord{});
    if (known || retained_record_) {
        position.source =
            static_cast<std::uint8_t>(known ? link::PositionSource::memory : link::PositionSource::retained);
    }
    position.job = record.job;
    position.items = record.items;
    position.fired = record.certain.fired;
    position.path = record.certain.at.path;
    position.pass = record.certain.at.pass;
    position.pulses = record.certain.at.pulses;
    position.reached_path = record.reached.at.path;
    position.reached_pass = record.reached.at.pass;
    position.reached_pulses = record.reached.at.pulses;
    link_.position(position);
}

bool Controller::geometry_may_change() const noexcept {
    return (state() == State::boot || state() == State::disabled || state() == State::idle) && runner_.at_rest();
}

/// A map and a field correction come in the same memory: to begin one is to drop what has come of the other.
Controller::Verdict Controller::take_map_chunk(const link::MapChunk& m) noexcept {
    if (!geometry_may_change()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    if (store_.busy()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};  // it writes from there
    }
    MapIntake* intake = std::get_if<MapIntake>(&intake_);
    if (intake == nullptr && m.offset == 0) {
        intake = &intake_.emplace<MapIntake>();
        field_numbers_ = 0;
    }
    if (intake == nullptr || !intake->take(m.offset, std::span(m.data.data).first(m.data.size))) {
        return {Refusal::map_incomplete, intake == nullptr ? 0 : static_cast<std::int64_t>(intake->size())};
    }
    return {};
}

Controller::Verdict Controller::set_map(const link::SetMap& m) noexcept {
    if (!geometry_may_change()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    MapCost cost;
    if (m.bytes == 0) {
        runner_.set_map(kNoMap, cost);
        map_crc_ = 0;
        return {};
    }
    MapIntake* intake = std::get_if<MapIntake>(&intake_);
    if (intake == nullptr || !intake->whole(m.bytes, m.crc)) {
        return {Refusal::map_incomplete, intake == nullptr ? 0 : static_cast<std::int64_t>(intake->size())};
    }
    const AxisMap* map = intake->map();
    if (map == nullptr) {
        return {Refusal::bad_map, 0};
    }
    if (const MapFinding finding = check_map(machine_, *map, cost); finding.refusal != Refusal::none) {
        return {finding.refusal, finding.detail()};
    }
    runner_.set_map(*map, cost);
    map_crc_ = map->is_identity() ? 0 : m.crc;
    return {};
}

Controller::Verdict Controller::set_compensation(const link::SetCompensation& m) noexcept {
    if (!geometry_may_change()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    Compensation c;
    for (std::size_t i = 0; i < 3; ++i) {
        c.axis_from_h.row[i] = {m.axis_matrix[3 * i], m.axis_matrix[3 * i + 1], m.axis_matrix[3 * i + 2]};
    }
    c.axis_offset = {m.axis_offset[0], m.axis_offset[1], m.axis_offset[2]};
    c.galvo_from_field = m.galvo_matrix;
    c.galvo_offset = m.galvo_offset;
    // A compensation is a small correction: far from identity it is a mistake, and dangerous.
    constexpr double kLargestCorrection = 0.02;
    constexpr double kLargestOffset = 2e-3;
    for (std::size_t i = 0; i < 9; ++i) {
        const double identity = i % 4 == 0 ? 1.0 : 0.0;
        if (!finite(m.axis_matrix[i]) || absolute(m.axis_matrix[i] - identity) > kLargestCorrection) {
            return {Refusal::bad_config, static_cast<std::int64_t>(i)};
        }
    }
    for (std::size_t i = 0; i < 4; ++i) {
        const double identity = i % 3 == 0 ? 1.0 : 0.0;
        if (!finite(m.galvo_matrix[i]) || absolute(m.galvo_matrix[i] - identity) > kLargestCorrection) {
            return {Refusal::bad_config, static_cast<std::int64_t>(9 + i)};
        }
    }
    for (const double offset :
         {m.axis_offset[0], m.axis_offset[1], m.axis_offset[2], m.galvo_offset[0], m.galvo_offset[1]}) {
        if (!finite(offset) || absolute(offset) > kLargestOffset) {
            return {Refusal::bad_config, 13};
        }
    }
    runner_.set_compensation(c);
    return {};
}

Controller::Verdict Controller::set_galvo_field(const link::SetGalvoField& m) noexcept {
    if (!geometry_may_change()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    if (store_.busy()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};  // it writes what came before
    }
    if (m.first == 0) {
        field_numbers_ = 0;
    }
    const std::size_t end = std::size_t{m.first} + m.count;
    if (m.first != field_numbers_ || m.count > m.numbers.size() || end > GalvoField::kNumbers) {
        return {Refusal::bad_config, m.first};
    }
    GalvoField* field = std::get_if<GalvoField>(&intake_);
    if (m.count > 0) {
        if (field == nullptr) {
            field = &intake_.emplace<GalvoField>();
        }
        for (std::size_t i = 0; i < m.count; ++i) {
            field->set_number(m.first + i, m.numbers[i]);
        }
        field_numbers_ = end;
        return {};
    }
    if (field_numbers_ == 0) {
        runner_.drop_galvo_field();
        return {};
    }
    if (field == nullptr || field_numbers_ != GalvoField::kNumbers || !sound(*field)) {
        return {Refusal::bad_config, static_cast<std::int64_t>(field_numbers_)};
    }
    runner_.set_galvo_field(*field);
    return {};
}

Controller::Verdict Controller::set_power_curve(const link::SetPowerCurve& m) noexcept {
    static_assert(link::SetPowerCurve::kPoints == PowerCurve::kPoints);
    if (!geometry_may_change()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    PowerCurve curve;
    curve.count = m.count;
    curve.byte = m.bytes;
    curve.watts = m.watts;
    if (!sound(curve)) {
        return {Refusal::bad_power_curve, static_cast<std::int64_t>(sound_points(curve))};
    }
    runner_.set_power_curve(curve);
    return {};
}

Controller::Verdict Controller::set_galvo_lag(const link::SetGalvoLag& m) noexcept {
    if (!geometry_may_change()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    const GalvoLag lag{std::int64_t{m.latency_ns}, Frequency::from_si(m.natural_frequency_hz), m.damping};
    if (const int fault = fault_of(lag, machine_.galvo, machine_.galvo_period_ns); fault != 0) {
        return {Refusal::bad_galvo_lag, fault};
    }
    runner_.set_galvo_lag(lag.empty() ? lag_of(machine_.galvo) : lag);
    return {};
}

}  // namespace sc
