// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <sstream>

#include <nlohmann/json.hpp>

#include "host/cli/build_info.hpp"
#include "host/cli/cad_input.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/inspect_lines.hpp"
#include "host/cli/progress_printer.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/mesh.hpp"
#include "host/formats/scan.hpp"
#include "host/inspection/allowance_map.hpp"
#include "host/inspection/inspection.hpp"
#include "host/inspection/inspection_html.hpp"
#include "host/inspection/inspection_pictures.hpp"
#include "host/inspection/inspection_report.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell inspect --cad part.stl --scan cloud.ply
      every face asks for metal; how much is there, and how should the part be shifted inside its blank
  scribecell inspect --cad part.stl --scan cloud.ply --part part.toml --json
      faces, required allowances, reference points and datums from a machining description; one JSON object
  scribecell inspect --cad part.stl --scan cloud.ply --part part.toml --free x,y,rz --bound-mm 2 --lock A
      borrow with three motions, at most 2 mm, and leave datum plane A where it is
  scribecell inspect --cad part.stl --scan cloud.ply --part part.toml --what-if 0,0,0.46
      and what if it were shifted by 0.46 mm along z
  scribecell inspect --cad part.stl --scan cloud.ply --part part.toml --lines out --calibration cell.toml
      and where the datum planes meet the blank: out/lines.dxf, out/lines.csv, out/job.toml for `scribecell scribe`

Exit codes: 0 metal everywhere (after borrowing, if that was allowed); 1 not enough; 2 bad input or usage.)";

constexpr double kMapScale = 1e-3;  ///< metres at full colour

struct Words {
    std::string cad;
    std::string scan;
    std::string part;
    std::string cad_unit = "mm";
    std::string scan_unit = "mm";
    std::string align = "auto";
    std::string free = "x,y,z,rx,ry,rz";
    std::string lock;
    std::string what_if;
    std::string lines;
    std::string calibration;
    std::string recipe;
    std::string entry;
    std::string faces;
    std::string report;
    std::string map;
    std::string pictures;
    std::string serial;
    std::string user;
    double incidence_deg = 60.0;
    double require_mm = 0.0;
    double bound_mm = 5.0;
    double bound_deg = 1.0;
    unsigned threads = 0;
    bool no_borrow = false;
    bool open = false;
    bool json = false;
};

[[noreturn]] void refuse(const std::string& problem, const std::string& value, const std::string& action) {
    throw InputError({.file = {}, .problem = problem, .value = value, .action = action});
}

std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> out;
    std::istringstream in(text);
    for (std::string word; std::getline(in, word, ',');) {
        if (!word.empty()) {
            out.push_back(word);
        }
    }
    return out;
}

LengthUnit unit_of(const std::string& word, const char* option) {
    const auto unit = length_unit(word);
    if (!unit) {
        refuse(std::string(option) + " is no unit of length", word, "choose of: " + length_unit_names());
    }
    return *unit;
}

std::array<bool, 6> motions(const std::string& text) {
    constexpr std::array<const char*, 6> kNames{"x", "y", "z", "rx", "ry", "rz"};
    std::array<bool, 6> out{};
    for (const std::string& word : split(text)) {
        const auto found = std::ranges::find(kNames, word);
        if (found == kNames.end()) {
            refuse("--free names no motion", word, "choose of: x, y, z, rx, ry, rz");
        }
        out[static_cast<std::size_t>(found - kNames.begin())] = true;
    }
    return out;
}

/// x,y,z[,rx,ry,rz] in mm and degrees, about the middle of the CAD model.
Rigid<frame::W, frame::W> motion_of(const std::string& text, const DistanceField& field) {
    std::array<double, 6> v{};
    const std::vector<std::string> words = split(text);
    if (words.size() != 3 && words.size() != 6) {
        refuse("--what-if takes three or six numbers", text, "say: --what-if x,y,z or x,y,z,rx,ry,rz (mm, degrees)");
    }
    for (std::size_t i = 0; i < words.size(); ++i) {
        std::size_t end = 0;
        try {
            v[i] = std::stod(words[i], &end);
        } catch (const std::exception&) {
            end = 0;
        }
        if (end != words[i].size() || !std::isfinite(v[i])) {
            refuse("--what-if holds what is no number", words[i], "write numbers with a decimal point");
        }
    }
    const double radian = std::numbers::pi / 180.0;
    const Vec3 centre = 0.5 * (field.low() + field.high());
    const Mat3 turn = turn_by(radian * Vec3{v[3], v[4], v[5]});
    return {turn, centre - turn * centre + 1e-3 * Vec3{v[0], v[1], v[2]}};
}

void set_alignment(const Words& words, InspectionRequest& request) {
    if (words.align.starts_with("features:")) {
        request.align = AlignBy::features;
        request.features = split(words.align.substr(9));
        if (request.features.empty() || words.part.empty()) {
            refuse("--align features needs ids and a part", words.align,
                   "say: --align features:ID,ID --part PART.toml");
        }
        return;
    }
    for (const AlignBy by : {AlignBy::automatic, AlignBy::best_fit, AlignBy::references}) {
        if (words.align == name_of(by)) {
            request.align = by;
            if (by == AlignBy::references && words.part.empty()) {
                refuse("--align rps needs reference points", "no part is given", "add --part PART.toml");
            }
            return;
        }
    }
    refuse("--align is none of these", words.align, "choose of: auto, fit, rps, features:ID,ID");
}

InspectionRequest request_of(const Words& words, const std::optional<Part>& part) {
    InspectionRequest request;
    set_alignment(words, request);
    request.least = words.require_mm / 1e3;
    request.borrow = !words.no_borrow;
    request.open_allowed = words.open;
    request.threads = words.threads;
    request.lines = !words.lines.empty();
    request.borrowing.free = motions(words.free);
    const double turn = words.bound_deg * std::numbers::pi / 180.0;
    const double shift = words.bound_mm / 1e3;
    request.borrowing.bound = {shift, shift, shift, turn, turn, turn};
    for (const std::string& id : split(words.lock)) {
        const DatumPlane* found = nullptr;
        for (const DatumPlane& datum : part ? part->datums : std::vector<DatumPlane>{}) {
            if (datum.id == id) {
                request.borrowing.locked.push_back(datum);
                found = &request.borrowing.locked.back();
            }
        }
        if (found == nullptr) {
            refuse("--lock names no datum plane of the part", id, "name ids of [[datum]] entries, with --part");
        }
    }
    return request;
}

/// Degrees, with commas.
std::vector<double> angles(const std::string& text) {
    std::vector<double> out;
    for (const std::string& word : split(text)) {
        std::size_t end = 0;
        double value = 0.0;
        try {
            value = std::stod(word, &end);
        } catch (const std::exception&) {
            end = 0;
        }
        if (end != word.size() || !(std::abs(value) <= 360.0)) {
            refuse("--faces holds what is no angle", word, "say degrees from -360 to 360: --faces 0,90,180,270");
        }
        out.push_back(value);
    }
    return out;
}

/// Of a recipe's entry; of its only one if none is named.
MarkSettings settings_from(const std::string& file, const std::string& id) {
    const Recipe recipe = read_recipe(file);
    if (id.empty() && recipe.entries.size() == 1) {
        return recipe.entries.front().settings;
    }
    const RecipeEntry* entry = find_entry(recipe, id);
    if (entry == nullptr) {
        throw InputError({.file = file,
                          .problem = id.empty() ? "the recipe has several entries" : "is not in the recipe",
                          .value = id,
                          .action = "name one of them with --entry: " + entry_ids(recipe)});
    }
    return entry->settings;
}

/// Files besides the answer; what became of the lines.
struct Outputs {
    LineFiles files;
    std::optional<LineJob> lines;
    Uncertainty uncertainty;
};
Outputs write_outputs(const Inspection& inspection, const DistanceField& field, std::span<const Vec3> scan,
                      const Words& words, const std::optional<MarkSettings>& settings) {
    Outputs out;
    std::optional<CalibrationSet> calibration;
    if (!words.calibration.empty()) {
        calibration = read_calibration(words.calibration);
    }
    out.uncertainty = uncertainty_of(inspection, field, calibration ? &*calibration : nullptr);
    if (!words.pictures.empty()) {
        write_pictures(words.pictures, inspection, field);
    }
    if (!words.map.empty()) {
        write_map_ply(words.map, inspection, field, kMapScale);
    }
    if (!words.report.empty()) {
        write_text_file(words.report,
                        inspection_html(inspection, field,
                                        {{"CAD model", words.cad},
                                         {"scan", words.scan},
                                         {"part", words.part},
                                         {"serial number", words.serial},
                                         {"operator", words.user},
                                         {"calibration", calibration ? calibration->id : ""},
                                         {"scribecell", std::string(kVersion) + " (git " + kGitHash + ")"}},
                                        out.uncertainty));
    }
    if (!words.lines.empty()) {
        out.files.folder = words.lines;
        if (!words.calibration.empty()) {
            out.files.calibration = words.calibration;
        }
        out.files.settings = settings;
        out.files.faces = angles(words.faces);
        out.files.incidence_deg = words.incidence_deg;
        out.lines = write_lines(inspection, scan, out.files);
    }
    return out;
}

void print(const Inspection& inspection, const Words& words, const Outputs& outputs) {
    if (words.json) {
        nlohmann::ordered_json json = inspection_json(inspection);
        json["uncertainty"] = uncertainty_json(outputs.uncertainty);
        json["line_job"] = outputs.lines ? line_job_json(*outputs.lines) : nlohmann::ordered_json();
        std::printf("%s\n", json.dump(2).c_str());
        return;
    }
    std::fputs(inspection_text(inspection).c_str(), stdout);
    if (outputs.lines) {
        std::fputs(line_job_text(*outputs.lines, outputs.files).c_str(), stdout);
    }
}

int run(const Words& words) {
    ProgressPrinter printer(stderr_is_terminal());
    const auto say = [&](const std::string& text) { printer.step(text); };
    const std::optional<Part> part = words.part.empty() ? std::nullopt : std::optional<Part>(read_part(words.part));
    InspectionRequest request = request_of(words, part);
    std::optional<MarkSettings> settings;
    if (!words.recipe.empty()) {
        settings = settings_from(words.recipe, words.entry);
    }
    say("reading " + words.cad);
    MeshFile cad = read_cad(words.cad, unit_of(words.cad_unit, "--cad-unit"));
    say("reading " + words.scan);
    const ScanFile scan = read_scan(words.scan, unit_of(words.scan_unit, "--scan-unit"));
    const DistanceField field(std::move(cad.mesh));
    if (!words.what_if.empty()) {
        request.what_if = motion_of(words.what_if, field);
    }
    request.progress = [&](std::string_view step) { say(std::string(step)); };
    try {
        Inspection inspection = inspect(field, scan.cloud.points, part ? &*part : nullptr, request);
        if (scan.not_finite > 0) {
            inspection.notes.push_back(std::to_string(scan.not_finite) +
                                       " points of the scan are NaN and were left out");
        }
        print(inspection, words, write_outputs(inspection, field, scan.cloud.points, words, settings));
        const bool enough = inspection.after ? inspection.after->enough() : inspection.before.enough();
        return enough ? kDone : kFailed;
    } catch (const InspectionError& error) {
        throw InputError({.file = words.scan, .problem = error.what(), .value = {}, .action = {}});
    } catch (const InputError& error) {
        const bool features = error.problem().starts_with("feature") || error.problem().starts_with("the part");
        throw InputError({.file = !error.file().empty() ? error.file() : (features ? words.part : words.cad),
                          .line = error.line(),
                          .problem = error.problem(),
                          .value = error.value(),
                          .action = error.action()});
    }
}

}  // namespace

void add_inspect(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("inspect", "Scan against CAD: allowance over each face, and borrowing.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("--cad", words->cad, "the finished part: STL, PLY, OBJ or STEP, a closed solid")
        ->required()
        ->type_name("FILE");
    sub->add_option("--scan", words->scan, "the blank: PLY, PCD, XYZ, ASC, CSV or STL")->required()->type_name("FILE");
    sub->add_option("--part", words->part, "machined faces, datums, reference points")->type_name("FILE");
    sub->add_option("--cad-unit", words->cad_unit, "of the CAD file's numbers")
        ->type_name("UNIT")
        ->capture_default_str();
    sub->add_option("--scan-unit", words->scan_unit, "of the scan's numbers")->type_name("UNIT")->capture_default_str();
    sub->add_option("--align", words->align, "auto, fit, rps or features:ID,ID")
        ->type_name("HOW")
        ->capture_default_str();
    sub->add_option("--require-mm", words->require_mm, "of every face, without --part")
        ->check(CLI::Range(0.0, 1000.0))
        ->type_name("MM");
    sub->add_option("--free", words->free, "motions for borrowing")->type_name("LIST")->capture_default_str();
    sub->add_option("--bound-mm", words->bound_mm, "largest shift each way")
        ->check(CLI::Range(0.0, 1000.0))
        ->type_name("MM")
        ->capture_default_str();
    sub->add_option("--bound-deg", words->bound_deg, "largest turn each way")
        ->check(CLI::Range(0.0, 10.0))
        ->type_name("DEG")
        ->capture_default_str();
    sub->add_option("--lock", words->lock, "datum planes that stay where they are")->type_name("IDS");
    sub->add_option("--what-if", words->what_if, "allowance at this motion besides (mm, degrees)")
        ->type_name("X,Y,Z,...");
    auto* lines = sub->add_option("--lines", words->lines,
                                  "folder for the datum lines on the blank: DXF, and with --calibration a job")
                      ->type_name("DIR");
    auto* calibration =
        sub->add_option("--calibration", words->calibration, "of the cell that burns them (h_from_c, turntable)")
            ->type_name("FILE");
    auto* recipe = sub->add_option("--recipe", words->recipe, "laser recipe: how the lines are burnt")
                       ->type_name("FILE")
                       ->needs(lines)
                       ->needs(calibration);
    sub->add_option("--entry", words->entry, "of the recipe, if it has several")->type_name("ID")->needs(recipe);
    sub->add_option("--faces", words->faces, "turntable faces to burn from (default: 0,90,180,270)")
        ->type_name("DEG,...");
    sub->add_option("--incidence-deg", words->incidence_deg, "largest angle between beam and surface normal")
        ->check(CLI::Range(1.0, 85.0))
        ->type_name("DEG")
        ->capture_default_str();
    sub->add_option("--report", words->report, "one HTML page with tables, pictures and a map that turns")
        ->type_name("FILE.html");
    sub->add_option("--map", words->map, "coloured points with their margins, for any viewer")->type_name("OUT.ply");
    sub->add_option("--pictures", words->pictures, "map, histograms, sides and sections as SVG files")
        ->type_name("DIR");
    sub->add_option("--serial", words->serial, "serial number, for the report")->type_name("TEXT");
    sub->add_option("--operator", words->user, "who inspects, for the report")->type_name("TEXT");
    sub->add_option("--threads", words->threads, "0 = all cores")->type_name("N");
    sub->add_flag("--no-borrow", words->no_borrow, "measure only");
    sub->add_flag("--open", words->open, "do not refuse a CAD model that is not closed");
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
