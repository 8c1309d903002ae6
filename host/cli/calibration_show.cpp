// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "host/calibration/scribe_budget.hpp"
#include "host/cli/calibrate_places.hpp"
#include "host/cli/calibration.hpp"
#include "host/cli/calibration_age.hpp"
#include "host/cli/calibration_picture.hpp"
#include "host/cli/failure.hpp"
#include "host/formats/calibration_records.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/iso_time.hpp"
#include "host/measurement/robot_frames.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr const char* kShowExamples = R"(Examples:
  scribecell calibration show
      the store's current set: records with sigma, age and expiry
  scribecell calibration show new.toml --svg frames.svg)";
constexpr const char* kExportExamples = R"(Examples:
  scribecell calibration export --out cell7.toml
      the current set as it was imported, to take elsewhere (`calibration import`)
  scribecell calibration export 3 --as json
      with 4x4 matrices, quaternions and angles of every transform
  scribecell calibration export --as fanuc --transform h_from_c --out h_from_c.csv
      transforms as a table of poses: quaternion, abb, matrix, kuka or fanuc (docs/formats.md, "Poses"))";

struct Words {
    std::string set;
    std::string store;
    std::string svg;
    std::string as = "toml";
    std::string out;
    std::string transform;
    bool json = false;
};

Json record_json(const RecordSummary& record, const CalibrationSet& set, std::chrono::sys_seconds now) {
    Json json{{"id", record.id}, {"time", record.time}};
    if (const auto made = parse_iso_time(record.time)) {
        json["age_days"] = static_cast<double>((now - *made).count()) / 86'400.0;
    }
    const auto end = expiry_of(record.time, record.validity);
    json["expires"] = end ? Json(iso_time_text(*end)) : Json(nullptr);
    json["expired"] = end ? *end <= now : false;
    json["parents"] = record.parents;
    json["residual_rms_um"] = record.residual_rms ? Json(1e6 * *record.residual_rms) : Json(nullptr);
    json["note"] = record.note;
    if (const TransformRecord* transform = set.find(record.id)) {
        json["transform"] = transform_json(transform->rotation, transform->translation, transform->covariance);
        Json rows = Json::array();
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3& r = transform->rotation.row[i];
            rows.push_back({r.x, r.y, r.z, 1e3 * transform->translation[i]});
        }
        rows.push_back({0.0, 0.0, 0.0, 1.0});
        json["transform"]["matrix4_mm"] = rows;
    }
    return json;
}

Json set_json(const CalibrationSet& set) {
    const auto now = now_in_seconds();
    Json records = Json::array();
    for (const RecordSummary& record : record_summaries(set)) {
        records.push_back(record_json(record, set, now));
    }
    return {{"format", "scribecell-calibration-view"},
            {"version", 1},
            {"file", set.file.string()},
            {"id", set.id},
            {"parents", set.parents},
            {"time", set.time},
            {"note", set.note},
            {"sha256", set.sha256},
            {"records", records}};
}

/// Sigmas of a record's quantities, angles in mdeg, lengths in um.
std::string sigma_text(const CalibrationSet& set, const std::string& id) {
    for (const CovarianceBlock& block : covariance_blocks(set)) {
        if (block.id == id && (id == "turntable" || set.find(id) != nullptr)) {
            std::string out;
            for (std::size_t i = 0; i < block.at.size(); ++i) {
                out += fmt::format("{}{:.3g}{}", i == 0 ? "" : " ",
                                   std::sqrt(block.at[i][i]) * (block.lengths[i] == 1 ? 1e6 : 1e3 / kDegree),
                                   block.lengths[i] == 1 ? "um" : "mdeg");
            }
            return out;
        }
    }
    return "";
}

std::string set_text(const CalibrationSet& set) {
    const auto now = now_in_seconds();
    std::string out =
        fmt::format("{}: {}\nsha256 {}\nmade {}, from {}\n", set.file.string(), set.id, set.sha256, set.time,
                    set.parents.empty() ? "nothing earlier" : fmt::format("{}", fmt::join(set.parents, ", ")));
    out += set.note.empty() ? "" : set.note + "\n";
    out += fmt::format("{:<14} {:>9} {:<22} {:>9}  {}\n", "record", "age", "expires", "rms um", "1 sigma");
    for (const RecordSummary& record : record_summaries(set)) {
        const auto made = parse_iso_time(record.time);
        const auto end = expiry_of(record.time, record.validity);
        const std::string expires =
            end ? (*end <= now ? fmt::format("EXPIRED {} ago", span_text(now - *end)) : iso_time_text(*end)) : "-";
        out += fmt::format("{:<14} {:>9} {:<22} {:>9}  {}\n", record.id, made ? span_text(now - *made) : "-", expires,
                           record.residual_rms ? fmt::format("{:.2f}", 1e6 * *record.residual_rms) : "-",
                           sigma_text(set, record.id));
    }
    for (const TransformRecord& transform : set.transforms) {
        out += transform.id + ":\n" + transform_text(transform.rotation, transform.translation);
    }
    return out;
}

int show(const Words& words) {
    const CalibrationSet set = named_set(words.set, words.store);
    if (!words.svg.empty()) {
        write_text_file(words.svg, calibration_svg(set, now_in_seconds()));
    }
    if (words.json) {
        std::printf("%s\n", set_json(set).dump(2).c_str());
    } else {
        std::fputs(set_text(set).c_str(), stdout);
    }
    return 0;
}

std::string pose_header(const std::string& as) {
    if (as == "quaternion") {
        return "qw,qx,qy,qz";
    }
    if (as == "abb") {
        return "q1,q2,q3,q4";
    }
    if (as == "matrix") {
        return "r11,r12,r13,r21,r22,r23,r31,r32,r33";
    }
    return as == "kuka" ? "a,b,c" : "w,p,r";
}

std::string pose_row(const TransformRecord& record, const std::string& as) {
    const Vec3 t = 1e3 * record.translation;
    std::vector<double> rotation;
    if (as == "matrix") {
        for (const Vec3& row : record.rotation.row) {
            rotation.insert(rotation.end(), {row.x, row.y, row.z});
        }
    } else if (as == "kuka" || as == "fanuc") {
        auto abc = abc_of(record.rotation);
        if (as == "fanuc") {
            std::swap(abc[0], abc[2]);
        }
        rotation = {abc[0] / kDegree, abc[1] / kDegree, abc[2] / kDegree};
    } else {
        const auto q = quaternion_of(record.rotation);
        rotation.assign(q.begin(), q.end());
    }
    return fmt::format("{},{:.9g},{:.9g},{:.9g},{:.12g}\n", record.id, t.x, t.y, t.z, fmt::join(rotation, ","));
}

std::string exported(const CalibrationSet& set, const Words& words) {
    if (words.as == "toml") {
        return read_text_file(set.file);
    }
    if (words.as == "json") {
        return set_json(set).dump(2) + "\n";
    }
    std::string out = "view,x_mm,y_mm,z_mm," + pose_header(words.as) + "\n";
    bool any = false;
    for (const TransformRecord& record : set.transforms) {
        if (words.transform.empty() || words.transform == record.id) {
            out += pose_row(record, words.as);
            any = true;
        }
    }
    if (!any) {
        throw InputError({.file = set.file.string(),
                          .problem = "the set has no such transform",
                          .value = words.transform,
                          .action = "leave --transform out for all of them"});
    }
    return out;
}

int export_set(const Words& words) {
    const std::string text = exported(named_set(words.set, words.store), words);
    if (words.out.empty()) {
        std::fputs(text.c_str(), stdout);
    } else {
        write_text_file(words.out, text);
    }
    return 0;
}

void add_common(CLI::App& sub, Words& words) {
    sub.add_option("set", words.set, "file, or number, sha256 or id in the store (default: the current set)")
        ->type_name("SET");
    sub.add_option("--store", words.store, "folder of the store (default: below XDG_DATA_HOME)")->type_name("DIR");
}

}  // namespace

void add_calibration_show(CLI::App& calibration, int& exit_code) {
    CLI::App* sub = calibration.add_subcommand("show", "Records of a set: sigma, residuals, age, expiry.");
    sub->footer(kShowExamples);
    const auto words = std::make_shared<Words>();
    add_common(*sub, *words);
    sub->add_option("--svg", words->svg, "picture of the frames")->type_name("FILE");
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return show(*words); }); });
}

void add_calibration_export(CLI::App& calibration, int& exit_code) {
    CLI::App* sub = calibration.add_subcommand("export", "A set, or its transforms, for elsewhere.");
    sub->footer(kExportExamples);
    const auto words = std::make_shared<Words>();
    add_common(*sub, *words);
    sub->add_option("--as", words->as, "toml, json, or transforms as quaternion, abb, matrix, kuka, fanuc")
        ->check(CLI::IsMember({"toml", "json", "quaternion", "abb", "matrix", "kuka", "fanuc"}))
        ->capture_default_str();
    sub->add_option("--transform", words->transform, "this one alone")->type_name("ID");
    sub->add_option("--out", words->out, "file (default: stdout)")->type_name("FILE");
    sub->callback([words, &exit_code] { exit_code = guarded(false, [&words] { return export_set(*words); }); });
}

}  // namespace sc::host::cli
