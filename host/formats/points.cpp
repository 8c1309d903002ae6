// SPDX-License-Identifier: Apache-2.0
#include "host/formats/points.hpp"

#include <set>
#include <string>

#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

FacePoints read_points(const std::filesystem::path& path) {
    const CsvTable csv = CsvTable::read(path);
    csv.refuse_columns_beyond({"no", "x", "y", "z"});
    const std::size_t no = csv.column("no");
    const std::size_t x = csv.column("x");
    const std::size_t y = csv.column("y");
    const std::size_t z = csv.column("z");
    FacePoints out{.file = path, .points = {}};
    std::set<int> seen;
    for (std::size_t i = 0; i < csv.size(); ++i) {
        const int number = csv.integer(i, no);
        if (!seen.insert(number).second) {
            throw InputError({.file = path.string(),
                              .line = csv.line(i),
                              .problem = "point number appears twice",
                              .value = std::to_string(number),
                              .action = "number the points without repeats"});
        }
        const Vec3 place{csv.number(i, x) / 1e3, csv.number(i, y) / 1e3, csv.number(i, z) / 1e3};
        out.points.push_back({csv.line(i), number, place});
    }
    if (out.points.empty()) {
        throw InputError(
            {.file = path.string(), .problem = "has a header and no rows", .action = "give a row for each point"});
    }
    return out;
}

std::vector<RoutePoint> read_route(const std::filesystem::path& path) {
    const CsvTable csv = CsvTable::read(path);
    csv.refuse_columns_beyond({"x", "y", "z"});
    const std::size_t x = csv.column("x");
    const std::size_t y = csv.column("y");
    const std::size_t z = csv.column("z");
    std::vector<RoutePoint> route;
    for (std::size_t i = 0; i < csv.size(); ++i) {
        route.push_back({csv.line(i), {csv.number(i, x) / 1e3, csv.number(i, y) / 1e3, csv.number(i, z) / 1e3}});
    }
    if (route.size() < 2) {
        throw InputError({.file = path.string(),
                          .problem = "has fewer than two places",
                          .value = std::to_string(route.size()),
                          .action = "give a row for each place of the path"});
    }
    return route;
}

void write_points(const std::filesystem::path& path, const FacePoints& points) {
    std::string text = "no,x,y,z\n";
    for (const FacePoint& p : points.points) {
        text += std::to_string(p.no) + "," + fixed(p.place.x * 1e3, 4) + "," + fixed(p.place.y * 1e3, 4) + "," +
                fixed(p.place.z * 1e3, 4) + "\n";
    }
    write_text_file(path, text);
}

}  // namespace sc::host
