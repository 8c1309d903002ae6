// SPDX-License-Identifier: Apache-2.0
#include "host/cli/calibration.hpp"

#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/cli/calibration_age.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/calibration_records.hpp"
#include "host/formats/iso_time.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kExamples = R"(Examples:
  scribecell calibration import new.toml --note "after the sensor was remounted"
      into the store, and current from now on; what it replaces stays
  scribecell calibration list
  scribecell calibration show --svg frames.svg
      records, sigmas, age, expiry; picture of the frames
  scribecell calibration diff 3 4
      what changed, in sigmas, and how far it moves a place at the workpiece
  scribecell calibration rollback
      the set that was current before is current again; nothing is deleted
  scribecell calibration export --as kuka --out transforms.csv
  scribecell calibration budget --job my_job.toml
      error of scribing at each place, by source
  scribecell calibration drift --target then.csv --seen now.csv
      have the frames moved since? exit code 1 if so

Sets are named by file, by number or sha256 in the store, or not at all: the current one. Other commands take "store:" (or
"store:3", "store:4552fa") in place of a file: scribecell scribe --calibration store:

Exit codes: 0 done; 1 drifted; 2 bad input.)";

constexpr const char* kListExamples = R"(Examples:
  scribecell calibration list
  scribecell calibration list --store /srv/cell7/calibration --json)";
constexpr const char* kImportExamples = R"(Examples:
  scribecell calibration import new.toml
  scribecell calibration import new.toml --sha256 4552fa46... --note "from the other PC"
      refused if the file is another one than was meant)";
constexpr const char* kRollbackExamples = R"(Examples:
  scribecell calibration rollback
  scribecell calibration rollback 2 --note "set 3 was made with a loose target")";

struct Words {
    std::string store;
    std::string file;
    std::string name;
    std::string sha256;
    std::string note;
    bool json = false;
};

Json json_of(const StoredSet& set, const CalibrationStore& store) {
    return {{"no", set.no},
            {"sha256", set.sha256},
            {"id", set.id},
            {"imported", set.imported},
            {"source", set.source},
            {"file", store.file_of(set).string()},
            {"current", store.current() == nullptr ? false : store.current()->no == set.no}};
}

void print(const StoredSet& set, const CalibrationStore& store, bool json, const char* what) {
    if (json) {
        std::printf("%s\n", json_of(set, store).dump(2).c_str());
    } else {
        std::printf("%s\n", fmt::format("{} {}: {} ({})", what, set.no, set.id, set.sha256.substr(0, 12)).c_str());
    }
}

int list(const Words& words) {
    const CalibrationStore store = open_store(words.store);
    const auto now = now_in_seconds();
    if (words.json) {
        Json sets = Json::array();
        for (const StoredSet& set : store.sets()) {
            sets.push_back(json_of(set, store));
        }
        Json changes = Json::array();
        for (const StoreChange& change : store.changes()) {
            changes.push_back({{"time", change.time},
                               {"what", change.what},
                               {"from", change.from},
                               {"to", change.to},
                               {"note", change.note}});
        }
        const Json json{{"format", "scribecell-calibration-list"},
                        {"version", 1},
                        {"folder", store.folder().string()},
                        {"sets", sets},
                        {"changes", changes}};
        std::printf("%s\n", json.dump(2).c_str());
        return 0;
    }
    if (store.sets().empty()) {
        std::printf("%s: no sets\n", store.folder().string().c_str());
    }
    for (const StoredSet& set : store.sets()) {
        std::string state;
        try {
            const auto expired = expired_records(read_calibration(store.file_of(set)), now);
            for (const ExpiredRecord& record : expired) {
                state += fmt::format("; {} expired {} ago", record.id, span_text(now - record.since));
            }
        } catch (const std::exception& error) {
            state = fmt::format("; cannot be read: {}", error.what());
        }
        std::printf("%s\n", fmt::format("{} {:>3}  {}  {}  {}{}",
                                        store.current() != nullptr && store.current()->no == set.no ? "*" : " ", set.no,
                                        set.sha256.substr(0, 12), set.imported, set.id, state)
                                .c_str());
    }
    for (const StoreChange& change : store.changes()) {
        std::printf("%s\n", fmt::format("{}  {} {} -> {}{}{}", change.time, change.what, change.from, change.to,
                                        change.note.empty() ? "" : ": ", change.note)
                                .c_str());
    }
    return 0;
}

int import(const Words& words) {
    CalibrationStore store = open_store(words.store);
    const StoredSet& set = store.import(words.file, words.sha256, words.note);
    print(set, store, words.json, "current is now set");
    return 0;
}

int rollback(const Words& words) {
    CalibrationStore store = open_store(words.store);
    const StoredSet& set = store.rollback(words.name, words.note);
    print(set, store, words.json, "current is now set");
    return 0;
}

CLI::App* subcommand(CLI::App& calibration, const char* name, const char* what, const char* examples,
                     const std::shared_ptr<Words>& words) {
    CLI::App* sub = calibration.add_subcommand(name, what);
    sub->footer(examples);
    sub->add_option("--store", words->store, "folder of the store (default: below XDG_DATA_HOME)")->type_name("DIR");
    sub->add_flag("--json", words->json, "one JSON object");
    return sub;
}

}  // namespace

CalibrationStore open_store(const std::string& folder) {
    return CalibrationStore(folder.empty() ? CalibrationStore::default_folder() : std::filesystem::path(folder));
}

CalibrationSet named_set(const std::string& name, const std::string& folder) {
    if (!name.empty() && !names_stored_set(name) && std::filesystem::exists(name)) {
        return read_calibration(name);
    }
    const bool looks_like_file = name.ends_with(".toml") || name.find('/') != std::string::npos;
    if (looks_like_file) {
        return read_calibration(name);  // which says that it is missing
    }
    const CalibrationStore store = open_store(folder);
    const StoredSet& stored = store.find(names_stored_set(name) ? name.substr(name.find(':') + 1) : name);
    return read_calibration(store.file_of(stored));
}

void add_calibration_store(CLI::App& calibration, int& exit_code) {
    const auto words = std::make_shared<Words>();
    CLI::App* sub =
        subcommand(calibration, "list", "Sets of the store, and what was current when.", kListExamples, words);
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return list(*words); }); });
    sub = subcommand(calibration, "import", "Take a set into the store and make it current.", kImportExamples, words);
    sub->add_option("file", words->file, "calibration set")->type_name("FILE.toml")->required();
    sub->add_option("--sha256", words->sha256, "that the set must have")->type_name("HEX");
    sub->add_option("--note", words->note, "why, for the history");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return import(*words); }); });
    sub = subcommand(calibration, "rollback", "Make an earlier set current again.", kRollbackExamples, words);
    sub->add_option("set", words->name, "number, sha256 or id (default: what was current before)")->type_name("SET");
    sub->add_option("--note", words->note, "why, for the history");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return rollback(*words); }); });
}

void add_calibration(CLI::App& app, int& exit_code) {
    CLI::App* calibration =
        app.add_subcommand("calibration", "Calibration sets: store, compare, export, judge. (`calibrate` makes them.)");
    calibration->require_subcommand(1);
    calibration->footer(kExamples);
    add_calibration_store(*calibration, exit_code);
    add_calibration_show(*calibration, exit_code);
    add_calibration_export(*calibration, exit_code);
    add_calibration_diff(*calibration, exit_code);
    add_calibration_budget(*calibration, exit_code);
    add_calibration_drift(*calibration, exit_code);
}

}  // namespace sc::host::cli
