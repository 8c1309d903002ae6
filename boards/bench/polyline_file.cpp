// SPDX-License-Identifier: Apache-2.0
#include "boards/bench/polyline_file.hpp"

#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

namespace sc::bench {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, std::size_t line, const std::string& problem,
                       const std::string& action) {
    throw FileError(file.string() + ":" + std::to_string(line) + ": " + problem + "; " + action);
}

}  // namespace

std::vector<trajectory::Place> read_polyline(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) {
        throw FileError(file.string() + ": cannot be read; give a CSV file with the header x,y,z");
    }
    std::string line;
    std::getline(in, line);
    if (!line.empty() && line.back() == '\r') {
        line.pop_back();
    }
    const std::size_t columns = line == "x,y,z" ? 3 : (line == "x,y,z,c" ? 4 : 0);
    if (columns == 0) {
        fail(file, 1, "the header is '" + line + "'", "write x,y,z or x,y,z,c (mm, degrees)");
    }
    std::vector<trajectory::Place> points;
    for (std::size_t number = 2; std::getline(in, line); ++number) {
        if (!line.empty() && line.back() == '\r') {
            line.pop_back();
        }
        if (line.empty()) {
            continue;
        }
        trajectory::Place place{};
        std::string_view rest = line;
        for (std::size_t k = 0; k < columns; ++k) {
            const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), place[k]);
            const auto used = static_cast<std::size_t>(end - rest.data());
            const bool last = k + 1 == columns;
            const bool separated = last ? used == rest.size() : used < rest.size() && rest[used] == ',';
            if (error != std::errc{} || !std::isfinite(place[k]) || !separated) {
                fail(file, number, "'" + line + "' is not a row of " + std::to_string(columns) + " numbers",
                     "correct the row");
            }
            rest.remove_prefix(last ? used : used + 1);
        }
        points.push_back({place[0] * 1e-3, place[1] * 1e-3, place[2] * 1e-3, place[3]});
    }
    if (points.size() < 2) {
        fail(file, 1, "fewer than two points", "give a path");
    }
    return points;
}

}  // namespace sc::bench
