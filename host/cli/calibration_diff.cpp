// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/calibration/set_diff.hpp"
#include "host/cli/calibrate_places.hpp"
#include "host/cli/calibration.hpp"
#include "host/cli/failure.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kRare = 1e-3;
constexpr const char* kExamples = R"(Examples:
  scribecell calibration diff 3 4
  scribecell calibration diff old.toml new.toml --at -250,-290,-380 --json
      how far a place (mm, in h at face 0) is burnt elsewhere by the second set

sigmas: 1 or so where both sets are right about their own uncertainty and nothing has moved; chance: of as large a
difference then. A set that was made from the other shares its data, and differs by less.)";

struct Words {
    std::string a;
    std::string b;
    std::string store;
    std::string at;
    bool json = false;
};

Json json_of(const RecordDiff& record) {
    const auto scaled = [](const std::optional<double>& v, double factor) {
        return v ? Json(*v * factor) : Json(nullptr);
    };
    return {{"id", record.id},
            {"change", name_of(record.change)},
            {"turn_mdeg", scaled(record.turn, 1e3 / kDegree)},
            {"place_um", scaled(record.place, 1e6)},
            {"sigmas", scaled(record.sigmas, 1.0)},
            {"chance", scaled(record.chance, 1.0)},
            {"moves_um", record.moves ? vector_json(1e6 * *record.moves) : Json(nullptr)}};
}

std::string text_of(const RecordDiff& r) {
    const auto number = [](const std::optional<double>& v, double factor, int digits) {
        return v ? fmt::format("{:.{}f}", *v * factor, digits) : std::string("-");
    };
    std::string out = fmt::format("{:<12} {:<8} {:>11} {:>10} {:>8} {:>10}", r.id, name_of(r.change),
                                  number(r.turn, 1e3 / kDegree, 3), number(r.place, 1e6, 2), number(r.sigmas, 1.0, 2),
                                  r.chance ? fmt::format("{:.2g}", *r.chance) : "-");
    if (r.moves) {
        out += fmt::format("  {:>8.2f} {:>8.2f} {:>8.2f}", 1e6 * r.moves->x, 1e6 * r.moves->y, 1e6 * r.moves->z);
    }
    return out + (r.chance && *r.chance < kRare ? "  more than the sigmas allow\n" : "\n");
}

Vec3 place_of(const std::string& text) {
    const std::size_t first = text.find(',');
    const std::size_t second = first == std::string::npos ? first : text.find(',', first + 1);
    Vec3 mm;
    if (second == std::string::npos || !parse_number(text.substr(0, first), mm.x) ||
        !parse_number(text.substr(first + 1, second - first - 1), mm.y) ||
        !parse_number(text.substr(second + 1), mm.z)) {
        throw InputError({.problem = "--at is no place", .value = text, .action = "give x,y,z in mm"});
    }
    return 1e-3 * mm;
}

int run(const Words& words) {
    const CalibrationSet a = named_set(words.a, words.store);
    const CalibrationSet b = named_set(words.b, words.store);
    const Vec3 at = words.at.empty() ? default_place(a) : place_of(words.at);
    const SetDiff diff = diff_sets(a, b, at);
    if (words.json) {
        Json records = Json::array();
        for (const RecordDiff& record : diff.records) {
            records.push_back(json_of(record));
        }
        const Json json{{"format", "scribecell-calibration-diff"},
                        {"version", 1},
                        {"a", {{"id", a.id}, {"sha256", a.sha256}}},
                        {"b", {{"id", b.id}, {"sha256", b.sha256}}},
                        {"at_mm", vector_json(1e3 * at)},
                        {"records", records}};
        std::printf("%s\n", json.dump(2).c_str());
        return 0;
    }
    std::string out =
        fmt::format("from {} ({}) to {} ({})\n", a.id, a.sha256.substr(0, 12), b.id, b.sha256.substr(0, 12)) +
        fmt::format("{:<12} {:<8} {:>11} {:>10} {:>8} {:>10}  moves x, y, z um at {:.1f}, {:.1f}, {:.1f} mm\n",
                    "record", "", "turn mdeg", "place um", "sigmas", "chance", 1e3 * at.x, 1e3 * at.y, 1e3 * at.z);
    for (const RecordDiff& record : diff.records) {
        out += text_of(record);
    }
    std::fputs(out.c_str(), stdout);
    return 0;
}

}  // namespace

void add_calibration_diff(CLI::App& calibration, int& exit_code) {
    CLI::App* sub = calibration.add_subcommand("diff", "What changed from one set to another.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("from", words->a, "set: file, number, sha256 or id")->type_name("SET")->required();
    sub->add_option("to", words->b, "set (default: the current one)")->type_name("SET");
    sub->add_option("--at", words->at, "place at the workpiece, x,y,z in h, mm")->type_name("X,Y,Z");
    sub->add_option("--store", words->store, "folder of the store (default: below XDG_DATA_HOME)")->type_name("DIR");
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
