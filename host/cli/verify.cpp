// SPDX-License-Identifier: Apache-2.0
#include "host/cli/verify.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/verification/table_check.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kExamples = R"(Examples:
  scribecell verify --table examples/ras3dm/table1.csv
      figures of a table of measured and true places, recomputed from its digits, and what is odd about it
  scribecell verify --table mine.csv --limit-mm 0.15 --json
      exit code 1 if a deviation along an axis is larger
  scribecell verify --table mine.csv --maxima printed.csv --svg residuals.svg
      with the largest deviations that a report prints (face_deg,x,y,z and, optional, any; mm), and a picture
  scribecell verify record --job my_job.toml --out mine.csv
      makes such a table with a person who points the beam at each marker

The table: face_deg,no,mx,my,mz,tx,ty,tz and, optional, dx,dy,dz, in mm (docs/formats.md). Deviation is measured - true.
Not to be mistaken for `./run verify`, which burns such a table in the simulated cell.

Exit codes: 0 recomputed, warnings or not; 1 beyond --limit-mm, or warnings with --strict; 2 bad input.)";

struct Words {
    std::string table;
    std::string maxima;
    std::string svg;
    double limit_mm = 0.0;
    bool strict = false;
    bool json = false;
};

Json mm_json(const Vec3& v) { return {1e3 * v.x, 1e3 * v.y, 1e3 * v.z}; }

Json json_of(const DeviationFigures& f) {
    return {{"points", f.points},          {"largest_mm", mm_json(f.largest)}, {"largest_no", f.largest_no},
            {"rms_mm", mm_json(f.rms)},    {"mean_mm", mm_json(f.mean)},       {"rms_3d_mm", 1e3 * f.rms_3d},
            {"max_3d_mm", 1e3 * f.max_3d}, {"max_3d_no", f.max_3d_no}};
}

Json json_of(const TableFace& face) {
    Json json{{"face_deg", face.face_deg}};
    json.update(json_of(face.figures));
    json["after_rigid_fit"] = {{"rms_3d_mm", 1e3 * face.after_fit.rms_3d},
                               {"max_3d_mm", 1e3 * face.after_fit.max_3d},
                               {"rms_mm", mm_json(face.after_fit.rms)}};
    json["mean_by_chance"] = {face.mean_chance.x, face.mean_chance.y, face.mean_chance.z};
    json["off_plane_um"] = {1e6 * face.plane[0].rms, 1e6 * face.plane[1].rms, 1e6 * face.plane[2].rms};
    return json;
}

Json json_of(const std::optional<GlobalFit>& fit) {
    return fit ? Json{{"rms_3d_mm", 1e3 * fit->rms_3d}, {"max_3d_mm", 1e3 * fit->max_3d}, {"removed", fit->removed}}
               : Json(nullptr);
}

/// Points of which one axis, and of which the 3-D distance, is beyond a limit.
struct Beyond {
    std::size_t by_axis = 0;
    std::size_t in_space = 0;
};
Beyond beyond(const VerificationTable& table, double limit) {
    Beyond out;
    for (const TableRow& row : table.rows) {
        const Vec3 d = row.measured.v - row.truth.v;
        // Half a nanometre: digits that are the limit itself are not beyond it.
        const double bound = limit + 0.5e-9;
        out.by_axis += std::abs(d.x) > bound || std::abs(d.y) > bound || std::abs(d.z) > bound ? 1U : 0U;
        out.in_space += norm(d) > bound ? 1U : 0U;
    }
    return out;
}

Json json_of(const TableAssessment& a, const Words& words, const Beyond& over, bool passed) {
    Json faces = Json::array();
    for (const TableFace& face : a.faces) {
        faces.push_back(json_of(face));
    }
    Json grids = Json::array();
    for (const JogGrid& grid : a.grids) {
        grids.push_back({{"column", std::string(grid.of_truth ? "t" : "d") + grid.axis},
                         {"step_mm", 1e3 * grid.step},
                         {"within", grid.within},
                         {"values", grid.values},
                         {"log10_chance", grid.log10_chance}});
    }
    Json warnings = Json::array();
    for (const TableWarning& warning : a.warnings) {
        warnings.push_back({{"name", name_of(warning.finding)}, {"text", warning.text}, {"lines", warning.lines}});
    }
    Json json{{"format", "scribecell-table-check"}, {"version", 1}, {"file", words.table}};
    json["all"] = json_of(a.all);
    json["faces"] = faces;
    json["fits"] = {{"each_face", {{"rms_3d_mm", 1e3 * a.pooled_3d}, {"removed", a.removed_by_faces}}},
                    {"rigid", json_of(a.rigid)},
                    {"affine", json_of(a.affine)}};
    json["in_plane"] = {{"sigma_after_fits_mm", 1e3 * a.in_plane_sigma}, {"below_95_mm", 1e3 * a.in_plane_95}};
    json["zeroed_mean_by_chance"] = {a.zeroed_chance.x, a.zeroed_chance.y, a.zeroed_chance.z};
    json["grids"] = grids;
    if (words.limit_mm > 0.0) {
        json["limit"] = {{"mm", words.limit_mm}, {"beyond_by_axis", over.by_axis}, {"beyond_in_3d", over.in_space}};
    }
    json["warnings"] = warnings;
    json["passed"] = passed;
    return json;
}

std::string row_text(const std::string& name, const DeviationFigures& f, double fit_rms, double fit_max) {
    return fmt::format(
        "{:>6} {:>3} {:>8.3f} {:>6.3f} {:>6.3f} {:>7.3f} {:>6.3f} {:>6.3f} {:>8.4f} {:>7.4f} {:>7.4f} {:>7.3f} {:>6.3f}"
        " {:>7.3f} {:>6.3f}\n",
        name, f.points, 1e3 * std::abs(f.largest.x), 1e3 * std::abs(f.largest.y), 1e3 * std::abs(f.largest.z),
        1e3 * f.rms.x, 1e3 * f.rms.y, 1e3 * f.rms.z, 1e3 * f.mean.x, 1e3 * f.mean.y, 1e3 * f.mean.z, 1e3 * f.rms_3d,
        1e3 * f.max_3d, 1e3 * fit_rms, 1e3 * fit_max);
}

std::string text_of(const TableAssessment& a, const Words& words, const Beyond& over) {
    std::string out = fmt::format("{}: measured - true, mm\n", words.table) +
                      fmt::format("{:>6} {:>3} {:^22} {:^21} {:^24} {:^14} {:^14}\n", "face", "n", "max |x| |y| |z|",
                                  "rms x y z", "mean x y z", "3-D rms max", "own fit: same");
    double worst_fit = 0.0;
    for (const TableFace& face : a.faces) {
        worst_fit = std::max(worst_fit, face.after_fit.max_3d);
        out +=
            row_text(fmt::format("{:.6g}", face.face_deg), face.figures, face.after_fit.rms_3d, face.after_fit.max_3d);
    }
    out += row_text("all", a.all, a.pooled_3d, worst_fit);
    out += fmt::format("of the squared error a rigid fit of each face takes away {:.0f} %", 100.0 * a.removed_by_faces);
    if (a.rigid) {
        out += fmt::format(", one for all {:.0f} % (rms 3-D {:.3f} left)", 100.0 * a.rigid->removed,
                           1e3 * a.rigid->rms_3d);
    }
    if (a.affine) {
        out += fmt::format(", one affine {:.0f} %", 100.0 * a.affine->removed);
    }
    out +=
        fmt::format("\nin the face (x, z): {:.3f} mm, 1 sigma after the fits; 95 % are below {:.3f} mm as they stand\n",
                    1e3 * a.in_plane_sigma, 1e3 * a.in_plane_95);
    if (words.limit_mm > 0.0) {
        out += fmt::format("beyond {:.4g} mm: {} points along an axis, {} in 3-D\n", words.limit_mm, over.by_axis,
                           over.in_space);
    }
    for (const TableWarning& warning : a.warnings) {
        out += fmt::format("warning: {}: {}", name_of(warning.finding), warning.text);
        if (!warning.lines.empty()) {
            out += " (line";
            for (const int line : warning.lines) {
                out += fmt::format(" {}", line);
            }
            out += ")";
        }
        out += "\n";
    }
    return out;
}

std::vector<PrintedMaximum> read_maxima(const std::string& file) {
    std::vector<PrintedMaximum> out;
    if (file.empty()) {
        return out;
    }
    const CsvTable csv = CsvTable::read(file);
    csv.refuse_columns_beyond({"face_deg", "x", "y", "z", "any"});
    const auto value = [&csv](std::size_t row, std::string_view name) -> std::optional<double> {
        if (!csv.has(name) || csv.text(row, csv.column(name)).empty()) {
            return std::nullopt;
        }
        return csv.number(row, csv.column(name)) / 1e3;
    };
    for (std::size_t i = 0; i < csv.size(); ++i) {
        out.push_back({.line = csv.line(i),
                       .face_deg = csv.number(i, csv.column("face_deg")),
                       .axis = {value(i, "x"), value(i, "y"), value(i, "z")},
                       .any = value(i, "any")});
    }
    return out;
}

int run(const Words& words) {
    const PrintedTable table = read_printed_table(words.table);
    const std::vector<PrintedMaximum> maxima = read_maxima(words.maxima);
    const TableAssessment assessment = assess_table(table, maxima);
    for (const PrintedMaximum& printed : maxima) {
        const bool there = std::ranges::any_of(
            assessment.faces, [&printed](const TableFace& face) { return face.face_deg == printed.face_deg; });
        if (!there) {
            throw InputError({.file = words.maxima,
                              .line = printed.line,
                              .problem = "the table has no such face",
                              .value = fmt::format("{:.6g}", printed.face_deg),
                              .action = "give faces of " + words.table});
        }
    }
    if (!words.svg.empty()) {
        write_text_file(words.svg, table_svg(table.table, assessment));
    }
    const Beyond over = beyond(table.table, words.limit_mm / 1e3);
    const bool passed = (words.limit_mm <= 0.0 || over.by_axis == 0) && (!words.strict || assessment.warnings.empty());
    if (words.json) {
        std::printf("%s\n", json_of(assessment, words, over, passed).dump(2).c_str());
    } else {
        std::fputs(text_of(assessment, words, over).c_str(), stdout);
    }
    return passed ? kDone : kFailed;
}

}  // namespace

void add_verify(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("verify", "Recompute a verification table, or record one with a person.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("--table", words->table, "measured and true places, CSV")->type_name("FILE");
    sub->add_option("--maxima", words->maxima, "largest deviations that a report prints, CSV")->type_name("FILE");
    sub->add_option("--svg", words->svg, "picture of the deviations")->type_name("FILE");
    sub->add_option("--limit-mm", words->limit_mm, "largest deviation along an axis that is good")
        ->check(CLI::Range(1e-6, 1e3));
    sub->add_flag("--strict", words->strict, "a warning is a failure");
    sub->add_flag("--json", words->json, "one JSON object");
    add_verify_record(*sub, exit_code);
    sub->callback([words, sub, &exit_code] {
        if (!sub->get_subcommands().empty()) {
            return;
        }
        exit_code = guarded(words->json, [&words] {
            if (words->table.empty()) {
                throw InputError({.problem = "there is nothing to verify", .action = "give --table FILE.csv"});
            }
            return run(*words);
        });
    });
}

}  // namespace sc::host::cli
