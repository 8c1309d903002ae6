// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/faults/reactions.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace sc::faults {
namespace {

constexpr std::string_view kBegin = "<!-- combinations: begin -->\n";
constexpr std::string_view kEnd = "<!-- combinations: end -->\n";
constexpr std::array kStates{"boot",      "disabled",  "enabling", "idle",       "homing",          "jogging",
                             "arming",    "armed",     "running",  "marking",    "stopping",        "held",
                             "held_link", "disabling", "fault",    "previewing", "preview_stopping"};

/// Faults after which no fault may be latched, but another state comes.
constexpr std::array kStateTells{"host_silent", "link_cut", "reset"};

std::string outcome_of(const Row& row) {
    if (row.combination.state == "fault" && row.ended == "fault") {
        return "stays";
    }
    if (row.code != 0) {
        return "fault " + std::to_string(row.code);
    }
    const bool tells = std::ranges::find(kStateTells, row.combination.fault) != kStateTells.end();
    return tells ? "ends in " + row.ended : "no fault";
}

std::string_view text_of(Path path) {
    switch (path) {
        case Path::line: return "hardware, 1 µs";
        case Path::guard: return "guard, 110 µs";
        case Path::tick: return "tick, 1010 µs from its sample";
        case Path::slow: return "tick, once it is known";
        case Path::none: break;
    }
    return "need not";
}

/// By fault: how the light goes, and by outcome the states.
struct Reaction {
    Path path = Path::none;
    std::size_t combinations = 0;
    std::map<std::string, std::set<std::string>> states;
};
using Reactions = std::vector<std::pair<std::string, Reaction>>;

Reactions reactions_of(const std::vector<Row>& rows) {
    Reactions all;
    for (const std::string& fault : fault_names(false)) {
        Reaction reaction;
        for (const Row& row : rows) {
            if (row.combination.fault == fault && row.excluded.empty()) {
                reaction.path = row.verdict.path;
                ++reaction.combinations;
                reaction.states[outcome_of(row)].insert(row.combination.state);
            }
        }
        if (!reaction.states.empty()) {
            all.emplace_back(fault, std::move(reaction));
        }
    }
    return all;
}

std::string line_of(const std::string& fault, const Reaction& reaction) {
    std::string what;
    for (const auto& [outcome, states] : reaction.states) {
        what += (what.empty() ? "" : "; ") + outcome + ":";
        for (const char* state : kStates) {
            what += states.contains(state) ? std::string(what.back() == ':' ? " " : ", ") + state : "";
        }
    }
    return "| `" + fault + "` | " + std::string(text_of(reaction.path)) + " | " + what + " | " +
           std::to_string(reaction.combinations) + " |\n";
}

std::string read(const std::filesystem::path& page) {
    std::ifstream file(page, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Begin and end of the table within the page.
std::pair<std::size_t, std::size_t> place_of_table(const std::filesystem::path& page, const std::string& text) {
    const std::size_t begin = text.find(kBegin);
    const std::size_t end = text.find(kEnd);
    if (begin == std::string::npos || end == std::string::npos || end < begin) {
        throw std::runtime_error(page.string() + " has no marks of the table of combinations");
    }
    return {begin + kBegin.size(), end};
}

}  // namespace

void write_reactions(const std::filesystem::path& page, const std::vector<Row>& rows) {
    std::string text = read(page);
    const auto [begin, end] = place_of_table(page, text);
    std::string table =
        "| fault | the light goes by | what comes of it, by the state that it comes in | combinations "
        "|\n|---|---|---|---|\n";
    for (const auto& [fault, reaction] : reactions_of(rows)) {
        table += line_of(fault, reaction);
    }
    text.replace(begin, end - begin, table);
    std::ofstream out(page, std::ios::binary);
    out << text;
    if (!out.flush()) {
        throw std::runtime_error(page.string() + " cannot be written");
    }
}

std::vector<std::string> compare_reactions(const std::filesystem::path& page, const std::vector<Row>& rows) {
    const std::string text = read(page);
    const auto [begin, end] = place_of_table(page, text);
    std::map<std::string, std::string> lines;  // by fault
    std::istringstream table(text.substr(begin, end - begin));
    for (std::string line; std::getline(table, line);) {
        if (line.starts_with("| `")) {
            lines[line.substr(3, line.find('`', 3) - 3)] = line;
        }
    }
    std::vector<std::string> found;
    for (const auto& [fault, reaction] : reactions_of(rows)) {
        const std::string& line = lines[fault];
        if (line.find("| " + std::string(text_of(reaction.path)) + " |") == std::string::npos) {
            found.push_back(fault + ": the page does not say '" + std::string(text_of(reaction.path)) + "'");
        }
        for (const auto& [outcome, states] : reaction.states) {
            const std::size_t at = line.find(outcome + ": ");
            std::string named = at == std::string::npos ? "" : line.substr(at + outcome.size() + 2);
            named = ", " + named.substr(0, named.find_first_of(";|")) + ",";
            std::ranges::replace(named, ' ', ',');
            for (const std::string& state : states) {
                if (named.find("," + state + ",") == std::string::npos) {
                    found.push_back(fault + " in " + state + ": '" + outcome + "', which the page does not say");
                }
            }
        }
    }
    return found;
}

}  // namespace sc::faults
