// SPDX-License-Identifier: Apache-2.0
#include "host/formats/stations.hpp"

#include <map>
#include <numbers>
#include <set>
#include <sstream>

#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"
#include "host/formats/toml_reader.hpp"

namespace sc::host {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kLongestMm = 100'000.0;
constexpr double kLargestTiltDeg = 45.0;
constexpr std::array kReadings{"d1_mm", "d2_mm", "d3_mm"};
constexpr std::array kShifts{"shift_x_mm", "shift_y_mm", "shift_z_mm"};
constexpr std::array kTilts{"tilt_x_deg", "tilt_y_deg", "tilt_z_deg"};

/// Three ids from one text.
std::array<std::string, 3> three_ids(const std::string& text, const InputProblem& where) {
    std::istringstream in(text);
    std::array<std::string, 3> ids;
    std::string more;
    in >> ids[0] >> ids[1] >> ids[2];
    if (ids[2].empty() || (in >> more)) {
        InputProblem problem = where;
        problem.problem = "sensors: are not three ids";
        problem.value = shortened(text);
        problem.action = "give three, with blanks between";
        throw InputError(problem);
    }
    return ids;
}

class CsvStations {
public:
    explicit CsvStations(const CsvTable& csv) : csv_(csv) {}

    StationFile read() {
        std::vector<std::string_view> known{"station", "rail_mm", "age_ms", "fault", "sensors"};
        known.insert(known.end(), kReadings.begin(), kReadings.end());
        known.insert(known.end(), kShifts.begin(), kShifts.end());
        known.insert(known.end(), kTilts.begin(), kTilts.end());
        csv_.refuse_columns_beyond(known);
        StationFile out{.file = csv_.file(), .stations = {}};
        for (std::size_t row = 0; row < csv_.size(); ++row) {
            Station& station = station_of(out, row);
            station.readings.push_back(reading(row));
        }
        if (out.stations.empty()) {
            throw InputError({.file = csv_.file().string(),
                              .problem = "has a header and no rows",
                              .action = "give a row for each reading"});
        }
        return out;
    }

private:
    [[nodiscard]] InputProblem where(std::size_t row) const {
        return {.file = csv_.file().string(), .line = csv_.line(row)};
    }

    [[noreturn]] void fail(std::size_t row, std::string problem, std::string value, std::string action) const {
        InputProblem p = where(row);
        p.problem = std::move(problem);
        p.value = std::move(value);
        p.action = std::move(action);
        throw InputError(p);
    }

    Station& station_of(StationFile& out, std::size_t row) {
        const std::string& id = csv_.text(row, csv_.column("station"));
        if (id.empty()) {
            fail(row, "station: is empty", {}, "name the station");
        }
        Station now;
        now.id = id;
        if (csv_.has("rail_mm")) {
            now.rail = csv_.number(row, csv_.column("rail_mm")) / 1e3;
        }
        if (csv_.has("sensors")) {
            now.sensors = three_ids(csv_.text(row, csv_.column("sensors")), where(row));
        }
        const auto [found, fresh] = index_.try_emplace(id, out.stations.size());
        if (fresh) {
            out.stations.push_back(now);
            return out.stations.back();
        }
        Station& station = out.stations[found->second];
        if (station.rail != now.rail) {
            fail(row, "rail_mm: differs within station " + shortened(id), decimal(now.rail.value_or(0.0) * 1e3),
                 "name stations apart, or correct it");
        }
        if (station.sensors != now.sensors) {
            fail(row, "sensors: differ within station " + shortened(id), joined(now.sensors, " "),
                 "leave the sensors as they are while a station is measured");
        }
        return station;
    }

    [[nodiscard]] double limited(std::size_t row, std::string_view column, double least, double most) const {
        const double value = csv_.number(row, csv_.column(column));
        if (!(value >= least && value <= most)) {
            fail(row, std::string(column) + ": is beyond " + about(least) + " to " + about(most), decimal(value),
                 "correct it");
        }
        return value;
    }

    [[nodiscard]] HeadReading reading(std::size_t row) const {
        HeadReading out;
        out.line = csv_.line(row);
        if (csv_.has("fault")) {
            out.fault = csv_.text(row, csv_.column("fault"));
        }
        for (std::size_t i = 0; i < 3; ++i) {
            // A sensor in fault has no value to give.
            const std::string& text = csv_.text(row, csv_.column(kReadings[i]));
            out.value[i] =
                !out.fault.empty() && text.empty() ? 0.0 : limited(row, kReadings[i], -kLongestMm, kLongestMm) / 1e3;
        }
        if (csv_.has("age_ms")) {
            out.age = limited(row, "age_ms", 0.0, 1e9) / 1e3;
        }
        out.pose.shift = triple(row, kShifts, kLongestMm, 1e-3);
        out.pose.tilt = triple(row, kTilts, kLargestTiltDeg, kDegree);
        return out;
    }

    [[nodiscard]] Vec3 triple(std::size_t row, const std::array<const char*, 3>& names, double most,
                              double factor) const {
        std::array<double, 3> v{};
        for (std::size_t i = 0; i < 3; ++i) {
            v[i] = csv_.has(names[i]) ? limited(row, names[i], -most, most) * factor : 0.0;
        }
        return {v[0], v[1], v[2]};
    }

    const CsvTable& csv_;
    std::map<std::string, std::size_t> index_;
};

HeadReading toml_reading(TomlReader& table) {
    HeadReading out;
    out.line = table.line();
    out.value = [&] {
        const auto v = table.numbers("d_mm", 3);
        return std::array{v[0] / 1e3, v[1] / 1e3, v[2] / 1e3};
    }();
    if (table.has("age_ms")) {
        out.age = table.number("age_ms", {0.0, 1e9}) / 1e3;
    }
    out.fault = table.text_or("fault", "");
    if (table.has("shift_mm")) {
        out.pose.shift = table.vector_mm("shift_mm");
    }
    if (table.has("tilt_deg")) {
        out.pose.tilt = kDegree * table.vector("tilt_deg");
    }
    table.finish();
    return out;
}

StationFile parse_toml(const std::filesystem::path& path, std::string_view text) {
    TomlDocument document(path, text, "scribecell-stations");
    TomlReader& root = document.root();
    StationFile out{.file = path, .stations = {}};
    std::set<std::string> seen;
    for (TomlReader& table : root.tables("station")) {
        Station station;
        station.id = table.text("id");
        if (!seen.insert(station.id).second) {
            table.fail("id", "appears twice", shortened(station.id), "put its readings into one [[station]]");
        }
        if (table.has("rail_mm")) {
            station.rail = table.number("rail_mm") / 1e3;
        }
        if (table.has("sensors")) {
            station.sensors =
                three_ids(joined(table.texts("sensors"), " "), {.file = path.string(), .line = table.line()});
        }
        for (TomlReader& reading : table.tables("reading")) {
            station.readings.push_back(toml_reading(reading));
        }
        if (station.readings.empty()) {
            table.fail("reading", "is missing", shortened(station.id), "add a [[station.reading]] for each");
        }
        table.finish();
        out.stations.push_back(std::move(station));
    }
    if (out.stations.empty()) {
        throw InputError({.file = path.string(), .problem = "has no station", .action = "add a [[station]]"});
    }
    root.finish();
    return out;
}

}  // namespace

StationFile parse_stations(const std::filesystem::path& path, std::string_view text) {
    if (path.extension() == ".toml") {
        return parse_toml(path, text);
    }
    const CsvTable csv = CsvTable::parse(path, text);
    return CsvStations(csv).read();
}

StationFile read_stations(const std::filesystem::path& path) { return parse_stations(path, read_text_file(path)); }

std::vector<KnownPose> read_known(const std::filesystem::path& path) {
    const CsvTable csv = CsvTable::read(path);
    csv.refuse_columns_beyond({"station", "angle_deg", "u_deg", "yaw_deg", "u_yaw_deg", "distance_mm", "u_mm"});
    const auto positive = [&](std::size_t row, std::string_view column) {
        const double value = csv.number(row, csv.column(column));
        if (!(value > 0.0)) {
            throw InputError({.file = path.string(),
                              .line = csv.line(row),
                              .problem = std::string(column) + ": is not above zero",
                              .value = decimal(value),
                              .action = "give one standard deviation of what is known"});
        }
        return value;
    };
    std::vector<KnownPose> out;
    std::set<std::string> seen;
    for (std::size_t row = 0; row < csv.size(); ++row) {
        KnownPose known;
        known.station = csv.text(row, csv.column("station"));
        if (!seen.insert(known.station).second) {
            throw InputError({.file = path.string(),
                              .line = csv.line(row),
                              .problem = "station appears twice",
                              .value = shortened(known.station),
                              .action = "keep one of them"});
        }
        known.angle = csv.number(row, csv.column("angle_deg")) * kDegree;
        known.angle_sigma = positive(row, "u_deg") * kDegree;
        if (csv.has("yaw_deg")) {
            known.yaw = csv.number(row, csv.column("yaw_deg")) * kDegree;
            known.yaw_sigma = positive(row, "u_yaw_deg") * kDegree;
        }
        if (csv.has("distance_mm")) {
            known.distance = csv.number(row, csv.column("distance_mm")) / 1e3;
            known.distance_sigma = positive(row, "u_mm") / 1e3;
        }
        out.push_back(known);
    }
    if (out.empty()) {
        throw InputError(
            {.file = path.string(), .problem = "has a header and no rows", .action = "give a row for each station"});
    }
    return out;
}

}  // namespace sc::host
