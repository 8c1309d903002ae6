// SPDX-License-Identifier: Apache-2.0
#include <string_view>

#include "host/calibration/axis_map_fit.hpp"
#include "host/calibration/map_solver.hpp"
#include "host/formats/csv.hpp"

namespace sc::host {
namespace {

int approach_of(const CsvTable& csv, std::size_t row, std::string_view column) {
    if (!csv.has(column)) {
        return 0;
    }
    const int way = csv.integer(row, csv.column(column));
    if (way < -1 || way > 1) {
        refuse_fit(csv.file(), csv.line(row), "the way of approach is neither -1 nor 0 nor 1", std::to_string(way),
                   "give the sign of the last motion, 0 if it is not known");
    }
    return way;
}

double metres(const CsvTable& csv, std::size_t row, std::string_view column) {
    return csv.number(row, csv.column(column)) * 1e-3;
}

Vec3 place_of(const CsvTable& csv, std::size_t row) {
    return {metres(csv, row, "true_x"), metres(csv, row, "true_y"), metres(csv, row, "true_z")};
}

}  // namespace

std::vector<AxesPoint> read_axes_points(const std::filesystem::path& file) {
    const CsvTable csv = CsvTable::read(file);
    csv.refuse_columns_beyond({"x", "y", "z", "dir_x", "dir_y", "dir_z", "true_x", "true_y", "true_z"});
    std::vector<AxesPoint> points;
    for (std::size_t row = 0; row < csv.size(); ++row) {
        AxesPoint point;
        point.reading = {metres(csv, row, "x"), metres(csv, row, "y"), metres(csv, row, "z")};
        point.approach = {approach_of(csv, row, "dir_x"), approach_of(csv, row, "dir_y"),
                          approach_of(csv, row, "dir_z")};
        point.place = place_of(csv, row);
        point.line = csv.line(row);
        if (norm(point.place - point.reading) > 2e-3) {
            refuse_fit(file, point.line, "the place is more than 2 mm from the reading", "", "give both in mm, in h");
        }
        points.push_back(point);
    }
    return points;
}

std::vector<TablePoint> read_table_points(const std::filesystem::path& file) {
    const CsvTable csv = CsvTable::read(file);
    csv.refuse_columns_beyond({"c", "dir_c", "target", "true_x", "true_y", "true_z"});
    std::vector<TablePoint> points;
    for (std::size_t row = 0; row < csv.size(); ++row) {
        points.push_back({csv.number(row, csv.column("c")), approach_of(csv, row, "dir_c"),
                          csv.integer(row, csv.column("target")), place_of(csv, row), csv.line(row)});
    }
    return points;
}

}  // namespace sc::host
