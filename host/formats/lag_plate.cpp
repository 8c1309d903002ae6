// SPDX-License-Identifier: Apache-2.0
#include "host/formats/lag_plate.hpp"

#include <cmath>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"

namespace sc::host {
namespace {

constexpr double kMostMm = 1e4;
constexpr int kMostMarks = 1'000'000;

class Rows {
public:
    Rows(const std::filesystem::path& path, const std::vector<std::string_view>& columns) : csv_(CsvTable::read(path)) {
        csv_.refuse_columns_beyond(columns);
        for (const std::string_view column : columns) {
            columns_.push_back(csv_.column(column));
        }
        if (csv_.size() == 0) {
            throw InputError(
                {.file = path.string(), .problem = "has a header and no rows", .action = "give a row for each"});
        }
    }
    [[nodiscard]] std::size_t size() const { return csv_.size(); }
    [[nodiscard]] int integer(std::size_t row, std::size_t column, int low, int high) const {
        const int value = csv_.integer(row, columns_[column]);
        if (value < low || value > high) {
            refuse(row, csv_.columns()[columns_[column]] + " is out of range", std::to_string(value),
                   "give " + std::to_string(low) + " to " + std::to_string(high));
        }
        return value;
    }
    /// In the file's unit, within [low, high].
    [[nodiscard]] double number(std::size_t row, std::size_t column, double low, double high) const {
        const double value = csv_.number(row, columns_[column]);
        if (!(value >= low && value <= high)) {
            refuse(row, csv_.columns()[columns_[column]] + " is out of range", decimal(value),
                   "give " + decimal(low) + " to " + decimal(high));
        }
        return value;
    }
    /// Millimetres to metres.
    [[nodiscard]] double length(std::size_t row, std::size_t column, double low = -kMostMm) const {
        return number(row, column, low, kMostMm) / 1e3;
    }
    [[nodiscard]] const std::string& text(std::size_t row, std::size_t column) const {
        return csv_.text(row, columns_[column]);
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
};

constexpr std::string_view kPlanHeader =
    "line,along,way,start_x,start_z,run,amplitude,wavelength,speed,pitch,anchor_x,anchor_y,anchor_z,told_latency_us,"
    "told_frequency_hz,told_damping\n";

LagLine read_line(const Rows& rows, std::size_t i) {
    LagLine line;
    line.no = rows.integer(i, 0, 1, kMostMarks);
    const std::string& along = rows.text(i, 1);
    if (along != "x" && along != "z") {
        rows.refuse(i, "along names no mirror", along, "write x or z");
    }
    line.along_x = along == "x";
    line.way = rows.integer(i, 2, -1, 1);
    if (line.way == 0) {
        rows.refuse(i, "way is none", "0", "write 1 or -1");
    }
    line.start = {rows.length(i, 3), rows.length(i, 4)};
    line.run = rows.length(i, 5, 1e-3);
    line.amplitude = rows.length(i, 6, 0.0);
    line.wavelength = rows.length(i, 7, 0.0);
    if ((line.amplitude > 0.0) != (line.wavelength > 0.0)) {
        rows.refuse(i, "a swing needs amplitude and wavelength", rows.text(i, 6) + ", " + rows.text(i, 7),
                    "give both, or 0 for both");
    }
    line.speed = rows.length(i, 8, 1e-3);
    line.pitch = rows.length(i, 9, 1e-4);
    line.anchor = {rows.length(i, 10), rows.length(i, 11), rows.length(i, 12)};
    return line;
}

}  // namespace

LagPlan read_lag_plan(const std::filesystem::path& path) {
    const Rows rows(path,
                    {"line", "along", "way", "start_x", "start_z", "run", "amplitude", "wavelength", "speed", "pitch",
                     "anchor_x", "anchor_y", "anchor_z", "told_latency_us", "told_frequency_hz", "told_damping"});
    LagPlan plan;
    std::set<int> seen;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        plan.lines.push_back(read_line(rows, i));
        if (!seen.insert(plan.lines.back().no).second) {
            rows.refuse(i, "a line appears twice", std::to_string(plan.lines.back().no), "number them without repeats");
        }
        const GalvoLag told{std::llround(rows.number(i, 13, 0.0, 1e4) * 1e3),
                            Frequency::from_si(rows.number(i, 14, 0.0, 1e6)), rows.number(i, 15, 0.0, 100.0)};
        if (i > 0 && !(told == plan.told)) {
            rows.refuse(i, "was burnt with another lag than the line before", rows.text(i, 13),
                        "give lines of one plate");
        }
        plan.told = told;
    }
    return plan;
}

void write_lag_plan(const std::filesystem::path& path, const LagPlan& plan) {
    std::string text(kPlanHeader);
    for (const LagLine& line : plan.lines) {
        text += std::to_string(line.no) + (line.along_x ? ",x," : ",z,") + std::to_string(line.way);
        for (const double metres : {line.start[0], line.start[1], line.run, line.amplitude, line.wavelength, line.speed,
                                    line.pitch, line.anchor.x, line.anchor.y, line.anchor.z}) {
            text += "," + fixed(metres * 1e3, 6);
        }
        text += "," + fixed(static_cast<double>(plan.told.latency_ns) * 1e-3, 3);
        text += "," + fixed(plan.told.natural_frequency.si(), 3) + "," + fixed(plan.told.damping, 6) + "\n";
    }
    write_text_file(path, text);
}

std::vector<LagMark> read_lag_marks(const std::filesystem::path& path) {
    const Rows rows(path, {"line", "mark", "x", "y", "z", "sigma"});
    std::vector<LagMark> out;
    std::set<std::pair<int, int>> seen;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const LagMark mark{rows.integer(i, 0, 1, kMostMarks),
                           rows.integer(i, 1, 0, kMostMarks),
                           {rows.length(i, 2), rows.length(i, 3), rows.length(i, 4)},
                           rows.length(i, 5)};
        if (!(mark.sigma > 0.0)) {
            rows.refuse(i, "sigma is not above zero", decimal(mark.sigma * 1e3),
                        "give the standard deviation of a measured coordinate, in millimetres");
        }
        if (!seen.insert({mark.line, mark.mark}).second) {
            rows.refuse(i, "a mark appears twice", std::to_string(mark.line) + ", " + std::to_string(mark.mark),
                        "number the marks of each line without repeats");
        }
        out.push_back(mark);
    }
    return out;
}

}  // namespace sc::host
