// SPDX-License-Identifier: Apache-2.0
#include "host/cli/board_input.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <glob.h>

#include "host/bridge/errors.hpp"
#include "host/bridge/stop.hpp"
#include "host/formats/board_points.hpp"
#include "host/formats/error.hpp"
#include "host/formats/length_unit.hpp"
#include "host/vision/board.hpp"

namespace sc::host::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kDrawn = 50.0;  ///< times as long
constexpr int kMostSide = 100'000;

[[noreturn]] void refuse(const std::string& problem, const std::string& value, const std::string& action) {
    throw InputError({.file = {}, .problem = problem, .value = value, .action = action});
}

/// "9x6".
GridSize size_of(const std::string& text, const char* option, int least) {
    GridSize out;
    const char* end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), end, out.columns);
    const bool cross = first.ec == std::errc{} && first.ptr != end && (*first.ptr == 'x' || *first.ptr == 'X');
    const auto second = cross ? std::from_chars(first.ptr + 1, end, out.rows) : first;
    if (!cross || second.ec != std::errc{} || second.ptr != end || out.columns < least || out.rows < least ||
        out.columns > kMostSide || out.rows > kMostSide) {
        refuse(std::string(option) + " is not of the form COLUMNSxROWS, " + std::to_string(least) + " each or more",
               text, std::string("give, say, ") + option + (least > 2 ? " 640x480" : " 9x6"));
    }
    return out;
}

double metres_of(const BoardWords& words) {
    const auto unit = length_unit(words.unit);
    if (!unit) {
        refuse("no unit of length", words.unit, "use one of " + length_unit_names());
    }
    return unit->metres;
}

void check(const BoardWords& words) {
    if (words.board.empty() || !(words.square > 0.0)) {
        refuse("the board is not described", words.board.empty() ? "--board" : "--square",
               "give --board COLUMNSxROWS (inner corners, or dots) and --square, the pitch");
    }
    const GridSize size = size_of(words.board, "--board", 2);
    if (size.columns > 200 || size.rows > 200) {
        refuse("a board of more than 200 points a side", words.board, "give --board COLUMNSxROWS of inner corners");
    }
}

BoardView view_of(const std::string& file, const BoardFound& found, const GreyImage& image, const BoardWords& words) {
    const double pitch = words.square * metres_of(words);
    BoardView out{.name = fs::path(file).stem().string(), .width = image.width, .height = image.height, .points = {}};
    for (const BoardCorner& c : found.corners) {
        out.points.push_back({.line = 0,
                              .column = c.column,
                              .row = c.row,
                              .place = {pitch * c.column, pitch * c.row, 0.0},
                              .seen = {c.x, c.y},
                              .sigma = 0.0,
                              .radius = words.dots ? 0.5 * words.dot_diameter * metres_of(words) : 0.0});
    }
    return out;
}

BoardInput from_pictures(const std::vector<std::string>& files, const BoardWords& words) {
    check(words);
    const GridSize size = size_of(words.board, "--board", 2);
    BoardInput out;
    for (const std::string& file : files) {
        if (stop_requested()) {
            throw Interrupted();
        }
        const GreyImage image = read_image(file);
        const auto found = words.dots ? find_dot_grid(image, size) : find_chessboard(image, size);
        if (found) {
            out.views.push_back(view_of(file, *found, image, words));
        } else {
            out.views.push_back(
                {.name = fs::path(file).stem().string(), .width = image.width, .height = image.height, .points = {}});
            out.notes.push_back(file + ": " + found.error());
        }
    }
    return out;
}

BoardInput from_points(const std::string& file, const BoardWords& words) {
    if (words.size.empty()) {
        refuse("points alone do not tell the size of the pictures", file, "give --size WIDTHxHEIGHT");
    }
    const GridSize size = size_of(words.size, "--size", 16);
    const double unit = metres_of(words);
    BoardInput out;
    std::map<std::string, std::size_t> known;
    for (const BoardPointRow& row : read_board_points(file, words.unit)) {
        const auto [at, fresh] = known.emplace(row.view, out.views.size());
        if (fresh) {
            out.views.push_back({.name = row.view, .width = size.columns, .height = size.rows, .points = {}});
        }
        if (!row.place && !(words.square > 0.0)) {
            refuse("the file has no places on the board", file, "add X_mm,Y_mm, or give --square, the pitch");
        }
        const Vec3 place =
            row.place.value_or(Vec3{words.square * unit * row.column, words.square * unit * row.row, 0.0});
        out.views[at->second].points.push_back({.line = row.line,
                                                .column = row.column,
                                                .row = row.row,
                                                .place = place,
                                                .seen = {row.u, row.v},
                                                .sigma = row.sigma,
                                                .radius = 0.5 * words.dot_diameter * unit});
    }
    return out;
}

bool is_table(const std::string& file) { return fs::path(file).extension() == ".csv"; }

/// The digits at the end of each name; none where a name has none or two are alike.
std::optional<std::vector<std::string>> numbers_of(const std::vector<std::string>& files) {
    std::vector<std::string> out;
    std::set<std::string> known;
    for (const std::string& file : files) {
        const std::string stem = fs::path(file).stem().string();
        const std::size_t at = stem.find_last_not_of("0123456789");
        const std::string number = at == std::string::npos ? stem : stem.substr(at + 1);
        if (number.empty() || !known.insert(number).second) {
            return std::nullopt;
        }
        out.push_back(number);
    }
    return out;
}

}  // namespace

void add_board_options(CLI::App& command, BoardWords& words) {
    command.add_option("--board", words.board, "columns and rows of inner corners, or of dots")->type_name("9x6");
    command.add_option("--square", words.square, "pitch of the board")->check(CLI::Range(1e-6, 1e6));
    command.add_option("--unit", words.unit, "of --square, --dot-diameter and X,Y without one: mm, m, inch")
        ->capture_default_str()
        ->type_name("UNIT");
    command.add_flag("--dots", words.dots, "a grid of dots; else a chessboard");
    command.add_option("--dot-diameter", words.dot_diameter, "takes out what perspective does to a dot's middle")
        ->check(CLI::Range(0.0, 1e6));
    command.add_option("--size", words.size, "of the pictures, where points come as a file")->type_name("640x480");
}

std::vector<std::string> expanded(const std::vector<std::string>& words) {
    std::vector<std::string> out;
    for (const std::string& word : words) {
        if (word.find_first_of("*?") == std::string::npos) {
            out.push_back(word);
            continue;
        }
        glob_t found{};
        if (glob(word.c_str(), 0, nullptr, &found) != 0) {
            globfree(&found);
            refuse("no file is named so", word, "check the pattern");
        }
        for (std::size_t i = 0; i < found.gl_pathc; ++i) {
            out.emplace_back(found.gl_pathv[i]);
        }
        globfree(&found);
    }
    return out;
}

BoardInput read_boards(const std::vector<std::string>& files, const BoardWords& words) {
    if (std::ranges::none_of(files, is_table)) {
        return from_pictures(files, words);
    }
    if (files.size() != 1) {
        refuse("points come as one CSV, or pictures as a list", std::to_string(files.size()) + " files",
               "give one CSV, or pictures alone");
    }
    return from_points(files.front(), words);
}

void pair_names(const std::vector<std::string>& left_files, std::vector<BoardView>& left,
                const std::vector<std::string>& right_files, std::vector<BoardView>& right) {
    if (is_table(left_files.front()) != is_table(right_files.front())) {
        refuse("left and right must both be pictures, or both a CSV", left_files.front() + ", " + right_files.front(),
               "give the same kind for both");
    }
    if (is_table(left_files.front())) {
        return;  // they have names
    }
    const auto left_numbers = numbers_of(left_files);
    const auto right_numbers = numbers_of(right_files);
    const bool by_number = left_numbers && right_numbers;
    if (!by_number && left.size() != right.size()) {
        refuse("left and right have different counts of pictures, and no numbers at the end of their names pair them",
               fmt::format("{} and {}", left.size(), right.size()), "give each left picture with its right one");
    }
    for (std::size_t i = 0; i < left.size(); ++i) {
        left[i].name = by_number ? (*left_numbers)[i] : std::to_string(i + 1);
    }
    for (std::size_t i = 0; i < right.size(); ++i) {
        right[i].name = by_number ? (*right_numbers)[i] : std::to_string(i + 1);
    }
}

Drawing residual_drawing(const std::vector<PointFit>& points, std::size_t view, std::size_t camera,
                         const GridSize& picture) {
    Drawing out{.width = picture.columns, .height = picture.rows, .shapes = {}};
    for (const PointFit& p : points) {
        if (p.view == view && p.camera == camera) {
            out.shapes.emplace_back(Drawing::Disc{.centre = p.seen, .radius = p.used ? 1.5 : 4.0});
            out.shapes.emplace_back(Drawing::Line{.from = p.seen,
                                                  .to = {p.seen[0] + kDrawn * p.off[0], p.seen[1] + kDrawn * p.off[1]},
                                                  .stroke = p.used ? Stroke::thin : Stroke::beam});
        }
    }
    out.shapes.emplace_back(Drawing::Text{.at = {8.0, picture.rows - 8.0},
                                          .font = Font::small,
                                          .anchor = Anchor::start,
                                          .text = fmt::format("residuals, {:.0f} times as long", kDrawn)});
    return out;
}

}  // namespace sc::host::cli
