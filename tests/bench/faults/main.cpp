// SPDX-License-Identifier: Apache-2.0
// The fault campaign: each fault in each state and phase, judged by an oracle of its own. `scribecell bench faults`
// runs it with the firmware as it is, and once more with the firmware whose rules can be taken out, one by one.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tests/bench/faults/campaign.hpp"
#include "tests/bench/faults/reactions.hpp"
#include "tests/bench/faults/rules.hpp"

namespace {

using namespace sc::faults;

struct Arguments {
    bool brief = false;
    bool strict = false;
    bool mutants = false;
    std::string raw;
    std::string write_page;
    std::string check_page;
    std::set<unsigned> only;
};

constexpr const char* kUsage =
    "usage: scribecell-fault-bench [--brief] [--strict] [--raw DIR] [--write-page PAGE | --check-page PAGE]\n"
    "       scribecell-fault-mutants [--mutants] [--only N[,N...]] [--brief] [--strict] [--raw DIR]\n"
    "--strict: ends with code 1 after a violation, a mutant that is missed, or a page that says otherwise\n"
    "--write-page: writes the table of combinations into PAGE (docs/hazards.md), between its marks\n"
    "--check-page: counts what PAGE says otherwise than the combinations have ended as violations\n";

std::string quoted(const std::vector<std::string>& texts) {
    std::string all;
    for (const std::string& text : texts) {
        all += (all.empty() ? "" : "; ") + text;
    }
    std::ranges::replace(all, '"', '\'');
    return "\"" + all + "\"";
}

std::string cell(const std::optional<double>& value) { return value ? fmt::format("{:.3f}", *value) : ""; }

void write_rows(const std::filesystem::path& file, const std::vector<Row>& rows) {
    std::ofstream out(file);
    out << "fault,state,phase,ran,excluded,fault_ns,light_us,trigger_us,gate_us,rest_ms,code,ended,violations\n";
    for (const Row& row : rows) {
        const Combination& c = row.combination;
        const Verdict& v = row.verdict;
        out << fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", c.fault, c.state, c.phase,
                           row.excluded.empty() ? 1 : 0, quoted({row.excluded}), c.fault_ns, cell(v.light_us),
                           cell(v.trigger_us), cell(v.gate_us), cell(v.rest_ms), row.code, row.ended,
                           quoted(v.violations));
    }
    if (!out.flush()) {
        throw std::runtime_error(file.string() + " cannot be written");
    }
}

/// States and phases that no moment of the job has, with the reason, for each fault.
void add_impossible(std::vector<Row>& rows, bool brief) {
    std::set<std::pair<std::string, std::string>> seen;
    for (const Row& row : rows) {
        seen.emplace(row.combination.state, row.combination.phase);
    }
    for (const char* state :
         {"boot", "disabled", "enabling", "idle", "homing", "jogging", "arming", "armed", "running", "marking",
          "stopping", "held", "held_link", "disabling", "fault", "previewing", "preview_stopping"}) {
        for (const char* phase : {"none", "ramp", "cruise", "corner", "jump", "dwell", "turning"}) {
            if (seen.contains({state, phase})) {
                continue;
            }
            for (const std::string& fault : fault_names(brief)) {
                Row row;
                row.combination.fault = fault;
                row.combination.state = state;
                row.combination.phase = phase;
                row.excluded = cannot_be(fault, state, phase);
                if (row.excluded.empty()) {
                    row.excluded = brief ? "not part of the brief campaign" : "";
                }
                if (row.excluded.empty()) {
                    row.verdict.violations.emplace_back("never run");
                }
                rows.push_back(row);
            }
        }
    }
}

double worst_tick(const std::vector<Row>& rows) {
    double most = 0.0;
    for (const Row& row : rows) {
        const bool tripped =
            row.combination.state != "fault" && must_trip(row.combination.fault, row.combination.state);
        most = row.excluded.empty() && tripped ? std::max(most, row.verdict.tick_us.value_or(0.0)) : most;
    }
    return most;
}

/// The same from the first sample of the inputs that can show the fault: design.md's tick and 10 µs.
double worst_after_sample(const std::vector<Row>& rows) {
    constexpr std::int64_t kTickNs = 1'000'000;
    double most = 0.0;
    for (const Row& row : rows) {
        const Combination& c = row.combination;
        if (row.excluded.empty() && c.state != "fault" && must_trip(c.fault, c.state)) {
            const double wait_us = static_cast<double>((kTickNs - c.fault_ns % kTickNs) % kTickNs) * 1e-3;
            most = std::max(most, row.verdict.tick_us.value_or(0.0) - wait_us);
            const bool by_tick = row.verdict.path == Path::tick;
            most = std::max(most, by_tick ? row.verdict.trigger_us.value_or(0.0) - wait_us : 0.0);
        }
    }
    return most;
}

double worst(const std::vector<Row>& rows, Path path, bool edges) {
    double most = 0.0;
    for (const Row& row : rows) {
        if (row.excluded.empty() && row.verdict.path == path &&
            must_trip(row.combination.fault, row.combination.state)) {
            most = std::max(most, row.verdict.light_us.value_or(0.0));
            most = std::max(most, edges ? row.verdict.trigger_us.value_or(0.0) : 0.0);
        }
    }
    return most;
}

nlohmann::ordered_json campaign(const Arguments& arguments) {
    CampaignOptions options;
    options.brief = arguments.brief;
    options.rule = arguments.only.empty() ? 0 : *arguments.only.begin();
    std::size_t done = 0;
    options.on_row = [&](const Row& row) {
        ++done;
        if (!row.verdict.violations.empty()) {
            std::fprintf(stderr, "%s in %s, %s: %s\n", row.combination.fault.c_str(), row.combination.state.c_str(),
                         row.combination.phase.c_str(), quoted(row.verdict.violations).c_str());
        } else if (done % 100 == 0) {
            std::fprintf(stderr, "%zu combinations\n", done);
        }
    };
    std::vector<Row> rows = Campaign(options).run();
    add_impossible(rows, arguments.brief);
    if (!arguments.raw.empty()) {
        std::filesystem::create_directories(arguments.raw);
        write_rows(std::filesystem::path(arguments.raw) / "faults.csv", rows);
    }
    if (!arguments.write_page.empty()) {
        write_reactions(arguments.write_page, rows);
    }
    if (!arguments.check_page.empty()) {
        for (const std::string& difference : compare_reactions(arguments.check_page, rows)) {
            std::fprintf(stderr, "%s: %s\n", arguments.check_page.c_str(), difference.c_str());
            Row row;
            row.verdict.violations.push_back(difference);
            rows.push_back(row);
        }
    }
    const auto ran = std::ranges::count_if(rows, [](const Row& row) { return row.excluded.empty(); });
    const auto wrong = std::ranges::count_if(rows, [](const Row& row) { return !row.verdict.violations.empty(); });
    const double off_by_tick_us = std::max(worst(rows, Path::tick, true), worst_tick(rows));
    return {{"combinations", ran},
            {"excluded", static_cast<std::ptrdiff_t>(rows.size()) - ran},
            {"violations", wrong},
            {"laser_off_hard_us", worst(rows, Path::line, false)},
            {"laser_off_guard_us", worst(rows, Path::guard, true)},
            {"laser_off_tick_us", off_by_tick_us},
            {"laser_off_tick_of_sample_us", worst_after_sample(rows)}};
}

/// A rule less at a time: the oracle must find each.
nlohmann::ordered_json mutants(const Arguments& arguments) {
    std::size_t missed = 0;
    std::size_t count = 0;
    std::ofstream table;
    if (!arguments.raw.empty()) {
        std::filesystem::create_directories(arguments.raw);
        table.open(std::filesystem::path(arguments.raw) / "mutants.csv");
        table << "number,rule,found,fault,state,phase,violations\n";
    }
    // A rule counts as found only where the firmware with all its rules does right.
    CampaignOptions right;
    right.brief = true;
    std::set<std::tuple<std::string, std::string, std::string>> wrong;
    Campaign first(right);
    for (const Row& row : first.run()) {
        if (!row.verdict.violations.empty()) {
            wrong.emplace(row.combination.fault, row.combination.state, row.combination.phase);
        }
    }
    if (!wrong.empty()) {
        throw std::runtime_error("the firmware with all its rules is in the wrong; mutants prove nothing");
    }
    for (const RemovedRule& rule : removable_rules()) {
        if (!arguments.only.empty() && !arguments.only.contains(rule.number)) {
            continue;
        }
        CampaignOptions options;
        options.brief = true;
        options.stop_at_first = true;
        options.path = first.path();
        options.rule = rule.number;
        const std::vector<Row> rows = Campaign(options).run();
        const auto found = std::ranges::find_if(rows, [](const Row& row) { return !row.verdict.violations.empty(); });
        ++count;
        missed += found == rows.end() ? 1U : 0U;
        const Row none;
        const Row& row = found == rows.end() ? none : *found;
        const std::string line = fmt::format("{},\"{}\",{},{},{},{},{}", rule.number, rule.rule,
                                             found == rows.end() ? 0 : 1, row.combination.fault, row.combination.state,
                                             row.combination.phase, quoted(row.verdict.violations));
        std::fprintf(stderr, "%s\n", line.c_str());
        table << line << '\n';
    }
    return {{"mutants", count}, {"mutants_missed", missed}};
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        const bool value = i + 1 < argc;
        if (word == "--brief") {
            arguments.brief = true;
        } else if (word == "--strict") {
            arguments.strict = true;
        } else if (word == "--mutants" && !removable_rules().empty()) {
            arguments.mutants = true;
        } else if (word == "--raw" && value) {
            arguments.raw = argv[++i];
        } else if (word == "--write-page" && value) {
            arguments.write_page = argv[++i];
        } else if (word == "--check-page" && value) {
            arguments.check_page = argv[++i];
        } else if (word == "--only" && value && !removable_rules().empty()) {
            std::istringstream numbers(argv[++i]);
            for (std::string number; std::getline(numbers, number, ',');) {
                arguments.only.insert(static_cast<unsigned>(std::strtoul(number.c_str(), nullptr, 10)));
            }
        } else {
            std::fprintf(stderr, "%s", kUsage);
            return 2;
        }
    }
    try {
        const auto figures = arguments.mutants ? mutants(arguments) : campaign(arguments);
        std::printf("%s\n", figures.dump().c_str());
        const std::string wrong = arguments.mutants ? "mutants_missed" : "violations";
        return arguments.strict && figures.at(wrong) != 0 ? 1 : 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "fault campaign: %s\n", error.what());
        return 1;
    }
}
