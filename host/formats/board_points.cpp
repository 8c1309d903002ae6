// SPDX-License-Identifier: Apache-2.0
#include "host/formats/board_points.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <tuple>

#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/length_unit.hpp"
#include "host/formats/text.hpp"

namespace sc::host {
namespace {

std::string lower(std::string text) {
    std::ranges::transform(text, text.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return text;
}

/// Where a column stands, and of which unit it is.
struct Column {
    std::size_t index = 0;
    double metres = 1.0;
};

[[noreturn]] void refuse(const CsvTable& csv, std::string problem, std::string value, std::string action) {
    throw InputError({.file = csv.file().string(),
                      .line = csv.header_line(),
                      .problem = std::move(problem),
                      .value = std::move(value),
                      .action = std::move(action)});
}

class Header {
public:
    Header(const CsvTable& csv, std::string_view unit) : csv_(csv), unit_(unit) {
        for (const std::string& name : csv.columns()) {
            names_.push_back(lower(name));
        }
        used_.assign(names_.size(), false);
    }

    std::optional<std::size_t> take(std::string_view name) {
        const auto at = std::ranges::find(names_, name);
        if (at == names_.end()) {
            return std::nullopt;
        }
        const auto index = static_cast<std::size_t>(at - names_.begin());
        used_[index] = true;
        return index;
    }
    std::size_t need(std::string_view name) {
        const auto index = take(name);
        return index ? *index : csv_.column(name);
    }
    std::optional<Column> length(std::string_view axis) {
        if (const auto index = take(axis)) {
            const auto unit = length_unit(unit_);
            if (!unit) {
                refuse(csv_, "a length without a unit", csv_.columns()[*index],
                       "name the column " + std::string(axis) + "_mm, or give --unit (" + length_unit_names() + ")");
            }
            return Column{.index = *index, .metres = unit->metres};
        }
        for (const std::string_view unit : {"mm", "m", "inch"}) {
            if (const auto index = take(std::string(axis) + "_" + std::string(unit))) {
                return Column{.index = *index, .metres = length_unit(unit)->metres};
            }
        }
        return std::nullopt;
    }
    void refuse_rest() const {
        for (std::size_t i = 0; i < names_.size(); ++i) {
            if (!used_[i]) {
                refuse(csv_, "unknown column", shortened(csv_.columns()[i]),
                       "use view,row,col,X_mm,Y_mm,Z_mm,u_px,v_px,sigma_px");
            }
        }
    }

private:
    const CsvTable& csv_;
    std::string_view unit_;
    std::vector<std::string> names_;
    std::vector<bool> used_;
};

}  // namespace

std::vector<BoardPointRow> read_board_points(const std::filesystem::path& path, std::string_view unit) {
    const CsvTable csv = CsvTable::read(path);
    Header header(csv, unit);
    const std::size_t view = header.need("view");
    const std::size_t row = header.need("row");
    const std::size_t column = header.need("col");
    const std::size_t u = header.need("u_px");
    const std::size_t v = header.need("v_px");
    const auto sigma = header.take("sigma_px");
    const auto x = header.length("x");
    const auto y = header.length("y");
    const auto z = header.length("z");
    header.refuse_rest();
    if (x.has_value() != y.has_value() || (z && !x)) {
        refuse(csv, "a place on the board needs both X and Y", x ? "X" : "Y", "give X_mm and Y_mm, or neither");
    }
    if (x && (x->metres != y->metres || (z && z->metres != x->metres))) {
        refuse(csv, "X, Y and Z have different units", csv.columns()[y->index], "give them in one unit");
    }
    std::vector<BoardPointRow> out;
    std::set<std::tuple<std::string, int, int>> known;
    for (std::size_t i = 0; i < csv.size(); ++i) {
        BoardPointRow point{.line = csv.line(i),
                            .view = csv.text(i, view),
                            .column = csv.integer(i, column),
                            .row = csv.integer(i, row),
                            .place = std::nullopt,
                            .u = csv.number(i, u),
                            .v = csv.number(i, v),
                            .sigma = sigma ? csv.number(i, *sigma) : 0.0};
        if (x) {
            point.place = Vec3{csv.number(i, x->index) * x->metres, csv.number(i, y->index) * y->metres,
                               z ? csv.number(i, z->index) * z->metres : 0.0};
        }
        if (point.sigma < 0.0) {
            throw InputError({.file = path.string(),
                              .line = point.line,
                              .problem = "sigma_px is below zero",
                              .value = csv.text(i, *sigma),
                              .action = "give 1 sigma, or 0 where it is not known"});
        }
        if (!known.emplace(point.view, point.column, point.row).second) {
            throw InputError({.file = path.string(),
                              .line = point.line,
                              .problem = "a view has this point twice",
                              .value = "view " + point.view + ", row " + std::to_string(point.row) + ", col " +
                                       std::to_string(point.column),
                              .action = "keep one of them"});
        }
        out.push_back(std::move(point));
    }
    return out;
}

}  // namespace sc::host
