// SPDX-License-Identifier: Apache-2.0
#include "host/formats/plate.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"

namespace sc::host {
namespace {

class Rows {
public:
    Rows(const std::filesystem::path& path, const std::vector<std::string_view>& columns,
         const std::vector<std::string_view>& more = {})
        : csv_(CsvTable::read(path)) {
        std::vector<std::string_view> known = columns;
        known.insert(known.end(), more.begin(), more.end());
        csv_.refuse_columns_beyond(known);
        for (const std::string_view column : columns) {
            columns_.push_back(csv_.column(column));
        }
        more_ = std::ranges::any_of(more, [this](std::string_view column) { return csv_.has(column); });
        for (const std::string_view column : more) {
            if (more_) {
                columns_.push_back(csv_.column(column));
            }
        }
        if (csv_.size() == 0) {
            throw InputError(
                {.file = path.string(), .problem = "has a header and no rows", .action = "give a row for each cross"});
        }
    }
    [[nodiscard]] std::size_t size() const { return csv_.size(); }
    [[nodiscard]] bool has_more() const { return more_; }
    [[nodiscard]] int number(std::size_t row) {
        const int no = csv_.integer(row, columns_[0]);
        if (!seen_.insert(no).second) {
            refuse(row, "number of a cross appears twice", std::to_string(no), "number the crosses without repeats");
        }
        return no;
    }
    /// Millimetres to metres.
    [[nodiscard]] double length(std::size_t row, std::size_t column) const {
        const double mm = csv_.number(row, columns_[column]);
        if (!(std::abs(mm) <= 1e4)) {
            refuse(row, "is not a place in a cell, in millimetres", decimal(mm), "give millimetres");
        }
        return mm / 1e3;
    }
    [[noreturn]] void refuse(std::size_t row, std::string problem, std::string value, std::string action) const {
        throw InputError({.file = csv_.file().string(),
                          .line = csv_.line(row),
                          .problem = std::move(problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }

private:
    CsvTable csv_;
    std::vector<std::size_t> columns_;
    std::set<int> seen_;
    bool more_ = false;
};

}  // namespace

std::vector<PlateCross> read_plate_plan(const std::filesystem::path& path) {
    Rows rows(path, {"no", "command_x", "command_z", "anchor_x", "anchor_y", "anchor_z"});
    std::vector<PlateCross> out;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        out.push_back({rows.number(i),
                       {rows.length(i, 1), rows.length(i, 2)},
                       {rows.length(i, 3), rows.length(i, 4), rows.length(i, 5)}});
    }
    return out;
}

void write_plate_plan(const std::filesystem::path& path, const std::vector<PlateCross>& crosses) {
    std::string text = "no,command_x,command_z,anchor_x,anchor_y,anchor_z\n";
    for (const PlateCross& c : crosses) {
        text += std::to_string(c.no);
        for (const double metres : {c.command[0], c.command[1], c.anchor.x, c.anchor.y, c.anchor.z}) {
            text += "," + fixed(metres * 1e3, 6);
        }
        text += "\n";
    }
    write_text_file(path, text);
}

std::vector<MeasuredCross> read_measured_crosses(const std::filesystem::path& path) {
    Rows rows(path, {"no", "x", "y", "z", "sigma"});
    std::vector<MeasuredCross> out;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const int no = rows.number(i);
        const double sigma = rows.length(i, 4);
        if (!(sigma > 0.0)) {
            rows.refuse(i, "sigma is not above zero", decimal(sigma * 1e3),
                        "give the standard deviation of a measured coordinate, in millimetres");
        }
        out.push_back({no, {rows.length(i, 1), rows.length(i, 2), rows.length(i, 3)}, sigma});
    }
    return out;
}

std::vector<SeenCross> read_seen_crosses(const std::filesystem::path& path) {
    Rows rows(path, {"no", "x", "y", "z", "sigma_x", "sigma_y", "sigma_z"}, {"width", "sigma_width"});
    std::vector<SeenCross> out;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        SeenCross cross{.no = rows.number(i),
                        .place = {rows.length(i, 1), rows.length(i, 2), rows.length(i, 3)},
                        .sigma = {rows.length(i, 4), rows.length(i, 5), rows.length(i, 6)}};
        if (rows.has_more()) {
            cross.width = rows.length(i, 7);
            cross.width_sigma = rows.length(i, 8);
        }
        const bool measured = cross.width != 0.0 || cross.width_sigma != 0.0;
        if (!(cross.sigma.x > 0.0 && cross.sigma.y > 0.0 && cross.sigma.z > 0.0) ||
            (measured && !(cross.width > 0.0 && cross.width_sigma > 0.0))) {
            rows.refuse(i, "a width or a sigma is not above zero", std::to_string(cross.no),
                        "give standard deviations in millimetres; width and sigma_width are both 0 where none was "
                        "measured");
        }
        out.push_back(cross);
    }
    return out;
}

}  // namespace sc::host
