// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/cell.hpp"

#include "firmware/recording/io_image.hpp"
#include "firmware/safety/frame_guard.hpp"

namespace sc::sim {
namespace {

/// Light of the last window may still come for two ticks after the state has changed.
constexpr int kRestTicks = 3;
constexpr std::int64_t kRunOutNs = 30'000'000'000;

bool at_rest(State state) {
    switch (state) {
        case State::boot:
        case State::disabled:
        case State::idle:
        case State::armed:
        case State::held:
        case State::held_link:
        case State::disabling:
        case State::fault: return true;
        case State::enabling:
        case State::homing:
        case State::jogging:
        case State::arming:
        case State::running:
        case State::marking:
        case State::stopping:
        case State::previewing:
        case State::preview_stopping: return false;
    }
    return false;
}

bool may_be_left(State state) {
    return state == State::fault || state == State::idle || state == State::disabled || state == State::boot;
}

CellOptions with_directory(CellOptions options) {
    if (!options.out.empty()) {
        std::filesystem::create_directories(options.out);
    }
    return options;
}

std::filesystem::path parameter_path(const CellOptions& options) {
    return options.memory.empty() ? "" : options.memory.string() + ".parameters";
}

std::unique_ptr<replay::LogFile> open_record(const CellOptions& options, const MachineConfig& machine) {
    if (options.record.empty()) {
        return nullptr;
    }
    replay::LogFile::Options log;
    log.file = options.record;
    log.limit_bytes = options.record_limit_bytes;
    log.machine = machine;
    log.boot_id = options.boot_id;
    log.plan_units = motion::kUnitsPerTick;
    log.seal = options.seal;
    return std::make_unique<replay::LogFile>(log);
}

}  // namespace

SimCell::SimCell(const CellOptions& options)
    : options_(with_directory(options)),
      world_(options_.world),
      plant_(options_.machine, world_, options_.script, safety::frame_guard, options_.drives),
      traces_(options_.out, options_.command_trace, trace_header_json(options_.machine, world_)),
      link_(make_link_line(options_.carrier, options_.baud, options_.machine.control_period_ns)),
      retained_(options_.memory),
      parameters_(parameter_path(options_)),
      start_(starting_machine(parameters_, options_.machine)),
      controller_(options_.controller(start_.machine, options_.boot_id, retained_.memory())),
      record_(open_record(options_, start_.machine)),
      outputs_{std::make_unique<ServoOutputs>(), std::make_unique<ServoOutputs>()} {
    controller_->keep_parameters_in(options_.memory.empty() ? nullptr : &parameters_, start_.generation);
    if (options_.seal) {
        controller_->fit_key(*options_.seal);
    }
}

void SimCell::push_link(std::span<const std::uint8_t> bytes) { link_->push_host(bytes); }

std::size_t SimCell::take_link(std::vector<std::uint8_t>& out) {
    const std::size_t count = link_tx_.size();
    out.insert(out.end(), link_tx_.begin(), link_tx_.end());
    link_tx_.clear();
    return count;
}

void SimCell::tick() {
    step_controller();
    plant_.accept(tick_, latest());
    traces_.tick(tick_, latest(), plant_.encoders());
    const ServoOutputs* acting = tick_ == 0 ? nullptr : outputs_[1 - newest_].get();
    plant_.play(tick_, acting, [this](const trace::PulseRecord& record) {
        traces_.pulse(record);
        if (options_.on_pulse) {
            options_.on_pulse(record);
        }
    });
    note_state();
    carry_link();
    ++tick_;
}

void SimCell::step_controller() {
    newest_ = 1 - newest_;
    ServoOutputs& outputs = *outputs_[newest_];
    recording::clear(outputs);
    ServoInputs inputs;
    inputs.tick = tick_;
    inputs.link_rx = link_rx_;
    plant_.sample(inputs);
    controller_->tick(inputs, outputs);
    parameters_.tick();
    if (record_) {
        record_->tick(inputs, outputs);
    }
}

void SimCell::carry_link() {
    link_->set_connected(plant_.link_connected());
    link_->push_controller(std::span(latest().link_tx).first(latest().link_tx_size));
    link_rx_.clear();
    link_->tick(link_rx_, link_tx_);
}

void SimCell::note_state() {
    ticks_at_rest_ = at_rest(state()) ? ticks_at_rest_ + 1 : 0;
    if (ticks_at_rest_ >= kRestTicks) {
        plant_.faults().came_to_rest();
    }
}

void SimCell::run_out() {
    const std::int64_t end = now_ns() + kRunOutNs;
    for (int settled = 0; settled < kRestTicks && now_ns() < end;) {
        tick();
        settled = may_be_left(state()) ? settled + 1 : 0;
    }
}

CellReport SimCell::report() const {
    CellReport report;
    report.state = state();
    report.faults = faults();
    report.first_fault = controller_->first_fault();
    report.board = controller_->board();
    report.figures = controller_->figures();
    report.now_ns = now_ns();
    report.pulses = plant_.pulses();
    report.last_pulse_ns = plant_.last_pulse_ns();
    report.laser = plant_.laser_counters();
    report.beam = plant_.beam_counters();
    report.pulse_width_ns = plant_.mopa().width_ns();
    report.galvo_words_dropped = plant_.galvo_words_dropped();
    report.command_trace_sha256 = traces_.hashes().commands();
    report.set_point_sha256 = traces_.hashes().set_points();
    report.laser_sha256 = traces_.hashes().laser();
    report.script_events = plant_.fault_records();
    report.errors = world_.errors();
    return report;
}

void SimCell::close() {
    traces_.close();
    if (record_) {
        record_->close();
    }
    if (!options_.out.empty()) {
        write_whole_file(options_.out / "cell.json", to_json(report()) + "\n");
    }
}

}  // namespace sc::sim
