// SPDX-License-Identifier: Apache-2.0
#include "host/cli/scribe_output.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

namespace sc::host::cli {
namespace {

std::string_view actuator_name(Actuator actuator) {
    constexpr std::array<std::string_view, 3> kNames{"axes", "galvo", "split"};
    return kNames.at(static_cast<std::size_t>(actuator));
}

using Json = nlohmann::ordered_json;

constexpr double kMmPerMetre = 1e3;

Json place_json(const Point<frame::H>& p) { return {p.v.x * kMmPerMetre, p.v.y * kMmPerMetre, p.v.z * kMmPerMetre}; }

std::size_t arcs_of(const PlannedPath& path) {
    return static_cast<std::size_t>(
        std::ranges::count_if(path.pieces, [](const Piece& piece) { return piece.circle.has_value(); }));
}

Json path_json(const PlannedPath& path) {
    Json json{{"path", path.id},
              {"face_deg", path.face_deg},
              {"kind", name_of(path.kind)},
              {"marker", path.marker},
              {"actuator", actuator_name(path.settings.actuator)},
              {"from_mm", place_json(path.from)},
              {"to_mm", place_json(path.to)},
              {"speed_mm_s", path.settings.speed.si() * kMmPerMetre},
              {"pitch_um", path.settings.pitch.si() * 1e6},
              {"energy_uj", path.settings.energy.si() * 1e6},
              {"passes", path.settings.passes},
              {"source", path.source.file.string()},
              {"line", path.source.line}};
    if (path.kind == PathKind::free_path) {
        json["name"] = path.name;
        json["length_mm"] = length(path.pieces) * kMmPerMetre;
        json["straight_pieces"] = path.pieces.size() - arcs_of(path);
        json["arcs"] = arcs_of(path);
    }
    return json;
}

Json plan_json(const ScribeOutcome& outcome) {
    const JobPlan& plan = outcome.plan;
    Json paths = Json::array();
    for (const PlannedPath& path : plan.paths) {
        paths.push_back(path_json(path));
    }
    return {{"dry_run", true},
            {"job", outcome.job_name},
            {"job_hash", fmt::format("{:016x}", plan.hash)},
            {"faces", plan.faces},
            {"items", plan.items.size()},
            {"paths", paths},
            {"expected_pulses", plan.expected_pulses},
            {"marked_mm", plan.marked_metres * kMmPerMetre},
            {"expected_seconds", plan.expected_seconds_estimate}};
}

Json progress_json(const ScribeOutcome& outcome) {
    const JobProgress& p = outcome.progress;
    return {{"items", outcome.plan.items.size()},
            {"sent", p.sent},
            {"planned", p.planned},
            {"fired", p.fired},
            {"path", p.path},
            {"pass", p.pass},
            {"pulses", p.pulses}};
}

/// Where the controller ran, and what a board other than this PC measured.
void add_board(Json& json, const ScribeOutcome& outcome) {
    if (outcome.cell) {
        json["board"] = outcome.cell->value("board", std::string());
        json["board_figures"] = outcome.cell->value("figures", Json());
    }
}

Json run_json(const ScribeOutcome& outcome) {
    Json json{{"state", outcome.state},
              {"job", outcome.job_name},
              {"job_hash", fmt::format("{:016x}", outcome.plan.hash)},
              {"progress", progress_json(outcome)},
              {"cell_seconds", outcome.cell_seconds},
              {"wall_seconds", outcome.wall_seconds}};
    if (outcome.journal) {
        json["journal"] = *outcome.journal;
    }
    if (outcome.cell) {
        json["cell"] = *outcome.cell;
    }
    return json;
}

Json preview_json(const ScribeOutcome& outcome) {
    const PreviewResult& preview = *outcome.preview;
    Json json{{"preview",
               {{"rounds", preview.rounds},
                {"stopped", preview.stopped},
                {"paths", outcome.plan.paths.size()},
                {"marked_mm", outcome.plan.marked_metres * kMmPerMetre},
                {"fastest_mm_s", outcome.machine.laser.guide_speed_max.si() * kMmPerMetre}}}};
    json.update(run_json(outcome));
    return json;
}

std::string place_text(const Point<frame::H>& p) {
    return fmt::format("{:9.3f} {:9.3f} {:9.3f}", p.v.x * kMmPerMetre, p.v.y * kMmPerMetre, p.v.z * kMmPerMetre);
}

}  // namespace

std::string plan_text(const ScribeOutcome& outcome) {
    const JobPlan& plan = outcome.plan;
    std::string text =
        fmt::format("job {} (hash {:016x}): {} items, not run\n\n", outcome.job_name, plan.hash, plan.items.size());
    text += fmt::format("{:>5} {:>6} {:<17} {:>6} {:<6} {:>29} {:>29} {:>8} {:>8}\n", "path", "face", "what", "marker",
                        "by", "from x y z, mm", "to x y z, mm", "mm/s", "pitch um");
    for (const PlannedPath& p : plan.paths) {
        text += fmt::format("{:>5} {:>6g} {:<17} {:>6} {:<6} {} {} {:>8g} {:>8g}\n", p.id, p.face_deg, name_of(p.kind),
                            p.marker == 0 ? std::string("-") : std::to_string(p.marker),
                            actuator_name(p.settings.actuator), place_text(p.from), place_text(p.to),
                            p.settings.speed.si() * kMmPerMetre, p.settings.pitch.si() * 1e6);
        if (p.kind == PathKind::free_path) {
            text += fmt::format("{:>30} {}: {:.3f} mm, {} straight pieces, {} arcs\n", "", p.name,
                                length(p.pieces) * kMmPerMetre, p.pieces.size() - arcs_of(p), arcs_of(p));
        }
    }
    text +=
        fmt::format("\n{} pulses over {:.1f} mm on {} faces; about {:.0f} s of the cell's time\n", plan.expected_pulses,
                    plan.marked_metres * kMmPerMetre, plan.faces.size(), plan.expected_seconds_estimate);
    return text;
}

Json outcome_json(const ScribeOutcome& outcome) {
    if (outcome.dry_run) {
        return plan_json(outcome);
    }
    if (outcome.failure) {
        Json json{{"error", to_json(*outcome.failure)}};
        json.update(run_json(outcome));
        return json;
    }
    if (outcome.preview) {
        return preview_json(outcome);
    }
    Json json = outcome.report ? report_json(*outcome.report) : run_json(outcome);
    add_board(json, outcome);
    return json;
}

std::string preview_text(const ScribeOutcome& outcome) {
    const PreviewResult& preview = *outcome.preview;
    std::string text = fmt::format(
        "{}: {} lines, {:.1f} mm, traced {} time{} with the guide laser at {:g} mm/s or less{}\n", outcome.job_name,
        outcome.plan.paths.size(), outcome.plan.marked_metres * kMmPerMetre, preview.rounds,
        preview.rounds == 1 ? "" : "s", outcome.machine.laser.guide_speed_max.si() * kMmPerMetre,
        preview.stopped ? ", and stopped in the next round" : "");
    if (outcome.cell) {
        text +=
            fmt::format("master oscillator on for {:g} s, gate for {:g} s, shutter open for {:g} s; {} pulses\n",
                        outcome.cell->value("master_oscillator_seconds", 0.0), outcome.cell->value("gate_seconds", 0.0),
                        outcome.cell->value("shutter_seconds", 0.0), outcome.cell->value("pulses", std::uint64_t{0}));
    }
    return text;
}

std::string board_text(const ScribeOutcome& outcome) {
    const Json figures = outcome.cell ? outcome.cell->value("figures", Json()) : Json();
    if (!figures.is_object()) {
        return {};
    }
    const auto line = [](const char* what, const Json& f) {
        return fmt::format("  {:<18} {:>10} {:>10} {:>10}\n", what, f.at("servo_max").at("count").get<std::uint64_t>(),
                           f.at("plan_max").at("count").get<std::uint64_t>(),
                           f.at("tick_max").at("count").get<std::uint64_t>());
    };
    return fmt::format("\nController on {}\n  most instructions  {:>10} {:>10} {:>10}\n",
                       outcome.cell->value("board", std::string()), "servo", "plan", "tick") +
           line("all ticks", figures.at("instructions")) + line("marking ticks", figures.at("instructions_marking")) +
           fmt::format("  stack used: {} of {} bytes; controller: {} bytes\n",
                       figures.at("stack_used_bytes").get<std::uint64_t>(),
                       figures.at("stack_size_bytes").get<std::uint64_t>(),
                       figures.at("controller_bytes").get<std::uint64_t>());
}

std::string how_far_text(const ScribeOutcome& outcome) {
    const JobProgress& p = outcome.progress;
    std::string text = fmt::format("state of the cell: {}\n", outcome.state);
    text += fmt::format("{}: {} of {} items sent, {} planned, {} fired",
                        outcome.journal ? "the journal says" : "the job came to", p.sent, outcome.plan.items.size(),
                        p.planned, p.fired);
    if (p.fired > 0 || p.pulses > 0) {
        text += fmt::format("; path {}, pass {}: {} pulses ({})", p.path, p.pass, p.pulses,
                            describe_item(outcome.plan, p.fired));
    }
    return text + "\n";
}

}  // namespace sc::host::cli
