// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/faults/campaign.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/bench/faults/once_each.hpp"
#include "tests/bench/faults/rules.hpp"

namespace sc::faults {
namespace {

constexpr std::int64_t kOffsetNs = 330'000;  ///< of the fault within its tick
constexpr std::int64_t kBlipNs = 250'000;    ///< two samples of the guard, none of a tick

struct Kind {
    std::string_view name;
    std::string_view broken;  ///< as a script has it; empty: done otherwise
    std::string_view mended;
    bool persists = false;  ///< its cause can be seen for as long as it is there, and forbids a reset
    bool brief = true;
};
constexpr std::array kKinds{
    Kind{"estop", "estop open", "estop close", true},
    Kind{"estop_blip", "estop open", "estop close"},
    Kind{"interlock", "interlock open", "interlock close", true},
    Kind{"interlock_blip", "interlock open", "interlock close"},
    Kind{"alarm", "laser alarm", "laser ok", true},
    Kind{"alarm_blip", "laser alarm", "laser ok"},
    Kind{"not_ready", "laser not_ready", "laser ok", true},
    Kind{"back_reflection", "laser back_reflection", "laser ok", true},
    Kind{"temperature", "laser temperature", "laser ok", true, false},
    Kind{"main_supply", "laser main_supply", "laser ok", true, false},
    Kind{"housekeeping", "laser housekeeping", "laser ok", true, false},
    Kind{"system", "laser system", "laser ok", true, false},
    Kind{"strange_code", "laser strange", "laser ok", true, false},
    Kind{"starting", "laser starting", "laser ok", true, false},
    Kind{"galvo_fail", "galvo fail", "galvo ok", true},
    Kind{"galvo_blip", "galvo fail", "galvo ok"},
    Kind{"galvo_float_low", "galvo float_low", "galvo ok", true, false},
    Kind{"galvo_float_high", "galvo float_high", "galvo ok", true, false},
    Kind{"galvo_absent", "galvo absent", "galvo ok"},
    Kind{"shutter_unplugged", "shutter unplugged", "shutter ok", true},
    Kind{"shutter_blip", "shutter unplugged", "shutter ok"},
    Kind{"shutter_dropped", "shutter dropped", "shutter ok"},
    Kind{"key_off", "key off", "key production", true},
    Kind{"key_setup", "key setup", "key production", true},
    Kind{"key_blip", "key off", "key production"},
    Kind{"drive_fault_x", "drive x fault 0x2310", ""},
    Kind{"drive_fault_c", "drive c fault 0x2310", "", false, false},
    Kind{"drive_silent_y", "drive y silent", "drive y recover", true},
    Kind{"bus_off", "", "", true},
    Kind{"freeze_x", "drive x freeze", "drive x recover"},
    Kind{"freeze_z", "drive z freeze", "drive z recover", false, false},
    Kind{"freeze_c", "drive c freeze", "drive c recover", false, false},
    Kind{"stall_x", "drive x stall", "drive x recover"},
    Kind{"stall_y", "drive y stall", "drive y recover", false, false},
    Kind{"stall_c", "drive c stall", "drive c recover", false, false},
    Kind{"encoder_jump_x", "", ""},
    Kind{"set_point_jump_x", "", ""},
    Kind{"rounding", "", ""},
    Kind{"no_plan", "", ""},
    Kind{"reset", "", ""},
    Kind{"missed_tick", "", ""},
    Kind{"host_silent", "", ""},
    Kind{"link_cut", "link cut", ""},
    Kind{"link_lost", "", ""},
};

const Kind& kind_of(const std::string& name) {
    return *std::ranges::find_if(kKinds, [&](const Kind& kind) { return kind.name == name; });
}

bool is_blip(const std::string& name) { return name.ends_with("_blip"); }

void board_fault(BoardTrouble& board, const std::string& name, bool on) {
    if (name == "bus_off") {
        board.bus_off = on;
    } else if (name == "encoder_jump_x") {
        board.jump_axis = on ? 0 : -1;
        board.off_counts = 1000;
    } else if (name == "set_point_jump_x") {
        board.shoved_axis = on ? 0 : -1;
        board.off_counts = 1000;
    } else if (name == "rounding") {
        board.rounding = on;
    } else if (name == "no_plan") {
        board.no_plan = on;
    } else if (name == "reset") {
        board.reset = on;
    } else if (name == "missed_tick") {
        board.missed_ticks = on ? 3 : 0;
    }
}

nlohmann::json pack(const Row& row) {
    const auto number = [](const std::optional<double>& value) {
        return value ? nlohmann::json(*value) : nlohmann::json();
    };
    const Verdict& v = row.verdict;
    return {{"fault_ns", row.combination.fault_ns},
            {"violations", v.violations},
            {"path", static_cast<int>(v.path)},
            {"light", number(v.light_us)},
            {"trigger", number(v.trigger_us)},
            {"gate", number(v.gate_us)},
            {"tick", number(v.tick_us)},
            {"rest", number(v.rest_ms)},
            {"ended", row.ended},
            {"code", row.code}};
}

void unpack(const nlohmann::json& json, Row& row) {
    const auto number = [&](const char* key) {
        return json.at(key).is_null() ? std::optional<double>() : json.at(key).get<double>();
    };
    Verdict& v = row.verdict;
    row.combination.fault_ns = json.at("fault_ns");
    v.violations = json.at("violations").get<std::vector<std::string>>();
    v.path = static_cast<Path>(json.at("path").get<int>());
    v.light_us = number("light");
    v.trigger_us = number("trigger");
    v.gate_us = number("gate");
    v.tick_us = number("tick");
    v.rest_ms = number("rest");
    row.ended = json.at("ended");
    row.code = json.at("code");
}

void want(bool done, const char* what) {
    if (!done) {
        throw std::runtime_error(std::string("the undisturbed cell does not ") + what);
    }
}

}  // namespace

std::vector<std::string> fault_names(bool brief) {
    std::vector<std::string> names;
    for (const Kind& kind : kKinds) {
        if (!brief || kind.brief) {
            names.emplace_back(kind.name);
        }
    }
    return names;
}

std::vector<Row> Campaign::run() {
    if (options_.path.empty()) {
        scout();
    } else {
        path_ = options_.path;
    }
    take_out(options_.rule);
    try {
        visit();
    } catch (const std::runtime_error& error) {
        reap(0);
        if (options_.rule == 0) {
            throw;
        }
        // Without the rule the cell does not get through its day: that is found too.
        Row row;
        row.combination.state = "all";
        row.combination.phase = "none";
        row.verdict.violations.emplace_back(error.what());
        keep(row);
    }
    reap(0);
    if (cell_ && !over()) {
        Row row;
        row.combination.fault = "";
        row.combination.state = "all";
        row.combination.phase = "none";
        cell_->trace().path = nullptr;
        row.verdict = judge(cell_->trace(), row.combination);
        keep(row);
    }
    take_out(0);
    return std::move(rows_);
}

/// What the undisturbed job burns.
void Campaign::scout() {
    cell_ = std::make_unique<FaultyCell>();
    test::CellRig& rig = cell_->rig();
    rig.make_ready();
    cell_->begin_job();
    run_job(link::Verb::start, State::armed, false);
    path_ = cell_->trace().burns;
    want(path_.size() > 1000, "burn");
}

std::string_view PhaseFinder::step(const Instant& instant, const std::array<double, 4>& command) {
    const bool rests = instant.speed == 0.0 && instant.turn == 0.0 && !instant.mirrors;
    resting_ = rests ? resting_ + 1 : 0;
    steady_ = std::abs(instant.speed - 60.0) < 0.6 ? steady_ + 1 : 0;
    strokes_ = instant.mirrors && instant.state == "marking" ? strokes_ + 1 : 0;
    const std::string_view phase = look(instant, command);
    if (phase.empty() || std::ranges::find(seen_, phase) != seen_.end()) {
        return {};
    }
    seen_.push_back(phase);
    return phase;
}

std::string_view PhaseFinder::look(const Instant& instant, const std::array<double, 4>& command) {
    // The bent line begins, and turns, here (mm).
    const double to_begin = std::hypot(command[0] + 258.0, command[2] + 394.0);
    const double to_corner = std::hypot(command[0] + 250.0, command[2] + 386.0);
    if (instant.speed > 150.0) {
        return "jump";
    }
    if (std::abs(instant.turn) > 20.0) {
        return "turning";
    }
    if (resting_ == 10) {
        return "dwell";
    }
    if (strokes_ == 8) {
        return "stroke";
    }
    if (steady_ == 45) {
        return "cruise";
    }
    if (to_begin < 6.0 && instant.acceleration > 0.0 && instant.speed > 25.0 && instant.speed < 59.0) {
        return "ramp";
    }
    if (to_corner < 0.2 && instant.speed > 5.0 && instant.speed < 70.0) {
        return "corner";
    }
    return {};
}

void Campaign::run_job(link::Verb verb, State done, bool visited) {
    test::CellRig& rig = cell_->rig();
    PhaseFinder finder;
    want(rig.command(verb).refusal == 0, "start its job");
    for (int limit = 0; limit < 60'000; ++limit) {
        const std::string_view phase = finder.step(cell_->instants().back(), cell_->trace().axes.back().command);
        if (visited && !phase.empty()) {
            at(phase == "stroke" ? "cruise" : std::string(phase));
        }
        if (over() || (rig.state() == done && (rig.status().flags & link::kFlagJobDone) != 0 && limit > 200)) {
            return;
        }
        rig.ticks(1);
    }
    want(false, "end its job");
}

/// Runs a job up to a phase of it.
void Campaign::to_moment(link::Verb verb, const std::string& wanted) {
    cell_->begin_job();
    PhaseFinder finder;
    want(cell_->rig().command(verb).refusal == 0, "start its job");
    for (int limit = 0; limit < 60'000; ++limit) {
        if (finder.step(cell_->instants().back(), cell_->trace().axes.back().command) == wanted) {
            return;
        }
        cell_->rig().ticks(1);
    }
    want(false, "come to a phase of its job");
}

void Campaign::visit() {
    cell_ = std::make_unique<FaultyCell>();
    test::CellRig& rig = cell_->rig();
    rig.ticks(5);
    at("none");  // boot
    rig.connect();
    want(rig.until_state(State::disabled, 5000), "find its drives");
    at("none");
    want(rig.command(link::Verb::enable).refusal == 0 && rig.until_state(State::enabling, 5), "enable");
    at("none");
    want(rig.until_state(State::idle, 5000), "enable");
    want(rig.command(link::Verb::home).refusal == 0 && rig.until_state(State::homing, 100), "home");
    rig.ticks(300);
    at("none");
    want(rig.until_state(State::idle, 120'000), "home");
    at("none");
    // Somebody points by the guide laser.
    cell_->guide_asked();
    want(rig.command(link::Verb::guide, 1).refusal == 0, "guide");
    rig.ticks(3);
    want(rig.command(link::Verb::jog, 0, -1'000'000, 50'000).refusal == 0 && rig.until_state(State::jogging, 5), "jog");
    rig.ticks(60);
    at("none");
    want(rig.until_state(State::idle, 5000), "jog");
    if (!over()) {
        visit_jobs();
    }
    if (!over()) {
        visit_stops();
    }
}

void Campaign::visit_jobs() {
    test::CellRig& rig = cell_->rig();
    rig.open_job(FaultyCell::job(), 1);
    want(rig.until([&] { return rig.refused().has_value(); }, 500), "refuse a job whose hash does not come out");
    cell_->begin_job();
    run_job(link::Verb::preview, State::idle, true);
    if (over()) {
        return;
    }
    to_moment(link::Verb::preview, "cruise");
    want(rig.command(link::Verb::abort).refusal == 0 && rig.until_state(State::preview_stopping, 5), "stop a preview");
    at("none");
    want(rig.until_state(State::idle, 5000), "stop a preview");
    want(rig.command(link::Verb::arm).refusal == 0 && rig.until_state(State::arming, 5), "arm");
    rig.ticks(100);
    at("none");  // warning
    rig.ticks(403);
    at("none");  // master oscillator
    want(rig.until_state(State::armed, 1000), "arm");
    rig.ticks(20);
    at("none");
    cell_->begin_job();
    run_job(link::Verb::start, State::armed, true);
}

void Campaign::stop_at(const std::string& phase, const std::string& label) {
    test::CellRig& rig = cell_->rig();
    to_moment(link::Verb::start, phase);
    want(rig.command(link::Verb::hold).refusal == 0, "hold");
    if (rig.state() == State::stopping) {
        at(label);
    }
    want(rig.until_state(State::held, 5000), "hold");
}

void Campaign::visit_stops() {
    test::CellRig& rig = cell_->rig();
    for (const char* phase : {"turning", "jump", "corner"}) {
        if (over()) {
            return;
        }
        stop_at(phase, phase);
        want(rig.command(link::Verb::abort).refusal == 0 && rig.until_state(State::armed, 5000), "abort");
    }
    const std::size_t burnt = cell_->trace().burns.size();
    stop_at("cruise", "ramp");
    rig.ticks(50);
    want(rig.state() == State::held, "stay held until it is told to go on");
    at("none");
    rig.speak(false);
    want(rig.until_state(State::held_link, 1000), "see its host fall silent");
    rig.ticks(20);
    at("none");
    rig.speak(true);
    rig.ticks(60);
    want(rig.command(link::Verb::resume).refusal == 0, "go on");
    want(rig.until([&] { return rig.state() == State::armed; }, 60'000), "end the job that was held");
    judge_resumed(burnt);
    cell_->inject("estop open", kOffsetNs);
    want(rig.until_state(State::fault, 10), "latch");
    rig.ticks(300);
    at("none");
    cell_->inject("estop close", kOffsetNs);
    rig.ticks(100);
    want(rig.command(link::Verb::reset_fault).refusal == 0 && rig.until_state(State::disabled, 100), "reset");
    want(rig.cell().faults() == 0, "forget its faults with a reset");
    want(rig.command(link::Verb::enable).refusal == 0 && rig.until_state(State::idle, 5000), "enable again");
    want(rig.command(link::Verb::disable).refusal == 0 && rig.until_state(State::disabling, 5), "disable");
    at("none");
}

/// The job that was held and has gone on: each pulse once.
void Campaign::judge_resumed(std::size_t from) {
    Row row;
    row.combination.state = "held";
    row.combination.phase = "resumed";
    cell_->trace().path = &path_;
    const std::string wrong = once_each(cell_->trace(), from);
    cell_->trace().path = nullptr;
    if (!wrong.empty()) {
        row.verdict.violations.push_back("a job that was held ends with " + wrong);
    }
    keep(std::move(row));
}

/// Forks a process for each fault that can come here and now.
void Campaign::at(const std::string& phase) {
    if (!options_.brief || phase == "cruise" || phase == "none" || phase == "jump") {
        for (const std::string& fault : fault_names(options_.brief)) {
            if (!over()) {
                hand_over(fault, phase);
            }
        }
    }
}

void Campaign::hand_over(const std::string& fault, const std::string& phase) {
    Row row;
    row.combination.fault = fault;
    row.combination.state = cell_->state();
    row.combination.phase = phase;
    const bool lost = fault == "link_lost" && row.combination.state != "held_link";
    const bool plan = fault == "no_plan" && row.combination.state != "running" && row.combination.state != "marking";
    row.excluded = lost   ? "only a job that is held can be lost"
                   : plan ? "nothing is planned in this state"
                          : cannot_be(fault, row.combination.state, phase);
    if (!row.excluded.empty()) {
        keep(row);
        return;
    }
    reap(static_cast<std::size_t>(options_.jobs - 1));
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) {
        throw std::runtime_error("no pipe");
    }
    std::fflush(nullptr);
    const int pid = fork();
    if (pid < 0) {
        throw std::runtime_error("cannot fork");
    }
    if (pid == 0) {
        std::string text;
        try {
            text = pack(suffer(row)).dump();
        } catch (const std::exception& error) {
            std::fprintf(stderr, "%s in %s: %s\n", fault.c_str(), row.combination.state.c_str(), error.what());
            _exit(1);
        }
        const bool written = write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size());
        _exit(written ? 0 : 1);
    }
    close(ends[1]);
    children_.push_back({pid, ends[0], std::move(row)});
}

void Campaign::reap(std::size_t most) {
    while (children_.size() > most) {
        Child child = std::move(children_.front());
        children_.erase(children_.begin());
        std::string text;
        std::array<char, 4096> buffer{};
        for (ssize_t got = 0; (got = read(child.pipe, buffer.data(), buffer.size())) > 0;) {
            text.append(buffer.data(), static_cast<std::size_t>(got));
        }
        close(child.pipe);
        int status = 0;
        waitpid(child.pid, &status, 0);
        const auto json = nlohmann::json::parse(text, nullptr, false);
        if (status == 0 && json.is_object()) {
            unpack(json, child.row);
        } else {
            child.row.verdict.violations.emplace_back("the cell broke down");
        }
        keep(std::move(child.row));
    }
}

void Campaign::keep(Row row) {
    violated_ = violated_ || !row.verdict.violations.empty();
    rows_.push_back(std::move(row));
    if (options_.on_row) {
        options_.on_row(rows_.back());
    }
}

/// In the forked process: the fault comes, its cause goes, the host asks for what it must not get, and for a reset.
Row Campaign::suffer(Row row) {
    Combination& combination = row.combination;
    test::CellRig& rig = cell_->rig();
    const Kind& kind = kind_of(combination.fault);
    const bool blip = is_blip(combination.fault);
    const std::int64_t offset_ns = rig.state() == State::marking ? cell_->before_trigger() : kOffsetNs;
    combination.fault_ns = cell_->now_ns() + (kind.broken.empty() ? 0 : offset_ns);
    if (!kind.broken.empty()) {
        cell_->inject(std::string(kind.broken), offset_ns);
    }
    if (blip) {
        cell_->inject(std::string(kind.mended), offset_ns + kBlipNs);
    }
    board_fault(cell_->board(), combination.fault, true);
    if (combination.fault == "galvo_absent" && rig.state() == State::idle) {
        (void)rig.command(link::Verb::arm);
    }
    if (combination.fault == "host_silent" || combination.fault == "link_lost") {
        rig.speak(false);
    }
    rig.ticks(combination.fault == "link_lost" ? 10'300 : combination.state == "boot" ? 4000 : 1000);
    const bool quiet = combination.fault == "host_silent" || combination.fault == "link_cut" ||
                       combination.fault == "link_lost" || combination.fault == "reset";
    if (rig.state() == State::fault && !quiet && combination.state != "boot") {
        rig.speak(true);
        rig.ticks(60);
        const bool there = kind.persists && !blip;
        for (const auto& [verb, name] : {std::pair{link::Verb::arm, "arm"}, std::pair{link::Verb::start, "start"},
                                         std::pair{link::Verb::resume, "resume"}}) {
            (void)cell_->ask(verb, name, there);
        }
        if (there) {
            (void)cell_->ask(link::Verb::reset_fault, "reset", true);
        }
        if (!kind.mended.empty() && !blip) {
            cell_->inject(std::string(kind.mended), kOffsetNs);
        }
        board_fault(cell_->board(), combination.fault, false);
        // A drive that has been away is set up anew.
        const bool away = combination.fault == "bus_off" || combination.fault == "drive_silent_y";
        rig.ticks(away ? 4000 : 300);
        if (combination.state != "fault") {
            (void)cell_->ask(link::Verb::reset_fault, "reset", false);
            rig.ticks(60);
        }
    }
    cell_->trace().path = &path_;
    row.verdict = judge(cell_->trace(), combination);
    row.ended = std::string(cell_->state());
    row.code = cell_->trace().states.back().first_fault;
    for (const StateSample& sample : cell_->trace().states) {
        row.code = sample.t_ns > combination.fault_ns && row.code == 0 ? sample.first_fault : row.code;
    }
    return row;
}

}  // namespace sc::faults
