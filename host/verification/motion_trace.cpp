// SPDX-License-Identifier: Apache-2.0
#include "host/verification/motion_trace.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/pulse_trace.hpp"
#include "host/formats/text.hpp"
#include "host/verification/motion_checker.hpp"
#include "host/verification/sample_checker.hpp"

namespace sc::host {

namespace {

using Json = nlohmann::json;

constexpr double kPeriod = 1e-3;
/// Times are printed with few digits at worst: µs must be right.
constexpr double kTimeSlack = 1.001e-6;
constexpr double kFarthestBase = 1e3;     // metres
constexpr double kFarthestDegrees = 1e6;  // degrees
constexpr double kFarthestTick = 1e12;

/// The two layouts of a CSV.
struct Layout {
    std::array<std::string_view, 5> columns;
    bool is_integer;
};
constexpr Layout kPlain{{"t_s", "x_m", "y_m", "z_m", "c_deg"}, false};
constexpr Layout kGrid{{"tick", "x_pm", "y_pm", "z_pm", "c_ndeg"}, true};

class CsvMotion {
public:
    explicit CsvMotion(const std::filesystem::path& path)
        : table_(CsvTable::read(path)), layout_(table_.has("tick") ? kGrid : kPlain) {
        table_.refuse_columns_beyond({layout_.columns.begin(), layout_.columns.end()});
        for (std::size_t i = 0; i < 4; ++i) {
            column_[i] = table_.column(layout_.columns[i]);
        }
        has_c_ = table_.has(layout_.columns[4]);
        column_[4] = has_c_ ? table_.column(layout_.columns[4]) : 0;
    }

    MotionTrace read() {
        if (table_.size() < 2) {
            throw InputError({.file = table_.file().string(),
                              .problem = "holds too few samples to be a motion",
                              .value = std::to_string(table_.size()),
                              .action = "give at least two"});
        }
        MotionTrace trace{.file = table_.file(), .samples = {}, .led = {}, .machine = {}, .has_c = has_c_};
        trace.samples.reserve(table_.size());
        trace.first_tick = std::llround(time(0) / kPeriod);
        for (std::size_t row = 0; row < table_.size(); ++row) {
            if (row > 0) {
                check_time(row);
            }
            AxisPositions& sample = trace.samples.emplace_back();
            for (std::size_t i = 0; i < kAxisCount; ++i) {
                sample[i] = i == 3 && !has_c_ ? 0 : place(row, i);
            }
        }
        trace.led.assign(trace.samples.size(), 1);
        return trace;
    }

private:
    [[nodiscard]] double time(std::size_t row) const {
        const double value = table_.number(row, column_[0]);
        if (layout_.is_integer) {
            check_whole(row, 0, value);
        }
        if (!(std::abs(value) <= kFarthestTick)) {
            refuse(row, 0, "is out of range", "count ticks from the start of the motion");
        }
        return layout_.is_integer ? value * kPeriod : value;
    }
    void check_time(std::size_t row) const {
        const double step = (time(row) - time(row - 1)) / kPeriod;
        const double slack = layout_.is_integer ? 1e-3 : kTimeSlack / kPeriod;
        // Steps alone would let a clock that runs slow or fast pass.
        const double since = (time(row) - time(0)) / kPeriod - static_cast<double>(row);
        if (std::abs(step - 1.0) <= slack && std::abs(since) <= slack) {
            return;
        }
        if (step >= 1.5 && std::abs(step - std::round(step)) <= slack) {
            refuse(row, 0, "follows a gap of " + std::to_string(std::llround(step - 1.0)) + " missing ticks",
                   "give every tick: nothing can be said of a gap");
        }
        refuse(row, 0, "is not one tick of 1 ms after the one before", "give samples at 1 kHz, in order");
    }
    [[nodiscard]] std::int64_t place(std::size_t row, std::size_t axis) const {
        const double value = table_.number(row, column_[axis + 1]);
        const double units = units_per_base(axis);
        const double most = axis == index(Axis::c) ? kFarthestDegrees : kFarthestBase;
        if (layout_.is_integer) {
            check_whole(row, axis + 1, value);
        }
        if (!(std::abs(value) <= most * (layout_.is_integer ? units : 1.0))) {
            refuse(row, axis + 1, "is beyond 1000 m or a million degrees", "check the unit that the column names");
        }
        return std::llround(layout_.is_integer ? value : value * units);
    }
    void check_whole(std::size_t row, std::size_t column, double value) const {
        if (std::nearbyint(value) != value) {
            refuse(row, column, "is not a whole number", "give whole units of the grid");
        }
    }
    [[noreturn]] void refuse(std::size_t row, std::size_t column, const std::string& problem,
                             const std::string& action) const {
        throw InputError({.file = table_.file().string(),
                          .line = table_.line(row),
                          .problem = "column " + std::string(layout_.columns[column]) + " " + problem,
                          .value = shortened(table_.text(row, column_[column])),
                          .action = action});
    }

    CsvTable table_;
    Layout layout_;
    std::array<std::size_t, 5> column_{};
    bool has_c_ = false;
};

MotionTrace read_cell_trace(const std::filesystem::path& path) {
    MotionTrace trace{
        .file = path, .samples = {}, .led = {}, .first_tick = 0, .machine = machine_of_trace(path), .has_c = true};
    trace.period = 1e-9 * static_cast<double>(trace.machine->control_period_ns);
    for_each_sample(path, [&trace](const trace::SampleRecord& record, std::span<const trace::GalvoSample>) {
        if (trace.samples.empty()) {
            trace.first_tick = record.tick;
        }
        const std::int64_t expected = trace.first_tick + static_cast<std::int64_t>(trace.samples.size());
        if (record.tick != expected) {
            throw InputError({.file = trace.file.string(),
                              .problem = "has no tick " + std::to_string(expected) + ", in its place stands tick",
                              .value = std::to_string(record.tick),
                              .action = "give every tick: nothing can be said of a gap"});
        }
        trace.samples.push_back(record.set_point);
        trace.led.push_back(leads_axes(record.state) ? 1 : 0);
    });
    if (trace.samples.empty()) {
        throw InputError(
            {.file = path.string(), .problem = "holds no samples", .action = "give the trace of a cell that has run"});
    }
    return trace;
}

double number_at(const Json& json, const char* key, double least, double most) {
    const auto value = json.at(key).get<double>();
    if (!(value >= least && value <= most)) {
        throw Json::other_error::create(0, std::string(key) + " is out of range: " + std::to_string(value), &json);
    }
    return value;
}

Vec3 vector_at(const Json& json, const char* key) {
    const Json& v = json.at(key);
    return {v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>()};
}

MachineConfig machine_from(const Json& header) {
    constexpr double kTiny = 1e-12;
    constexpr double kHuge = 1e15;
    const Json& json = header.at("machine");
    MachineConfig machine;
    machine.control_period_ns = static_cast<std::int64_t>(
        header.contains("control_period_ns") ? number_at(header, "control_period_ns", 1e3, 1e9) : 1e6);
    machine.galvo_period_ns = static_cast<std::int64_t>(number_at(json, "galvo_period_ns", 1e2, 1e9));
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        const Json& from = json.at("axis").at(i);
        AxisConfig& axis = machine.axis[i];
        axis.travel_min = number_at(from, "travel_min", -kHuge, kHuge);
        axis.travel_max = number_at(from, "travel_max", axis.travel_min, kHuge);
        axis.speed = number_at(from, "speed", kTiny, kHuge);
        axis.acceleration = number_at(from, "acceleration", kTiny, kHuge);
        axis.jerk = number_at(from, "jerk", kTiny, kHuge);
        axis.following_window = from.contains("following_window") ? number_at(from, "following_window", 0.0, kHuge)
                                                                  : std::numeric_limits<double>::infinity();
    }
    const Json& galvo = json.at("galvo");
    machine.galvo.half_field = Length::from_si(number_at(galvo, "half_field", kTiny, kHuge));
    machine.galvo.speed = Speed::from_si(number_at(galvo, "speed", kTiny, kHuge));
    machine.galvo.acceleration = Acceleration::from_si(number_at(galvo, "acceleration", kTiny, kHuge));
    machine.galvo.jerk = Jerk::from_si(number_at(galvo, "jerk", kTiny, kHuge));
    machine.y_retracted = Length::from_si(number_at(json, "y_retracted", -kHuge, kHuge));
    const Json& keep_out = json.at("keep_out");
    if (keep_out.size() > kKeepOutCapacity) {
        throw Json::other_error::create(0, "too many keep_out volumes: " + std::to_string(keep_out.size()), &json);
    }
    for (const Json& box : keep_out) {
        machine.keep_out[machine.keep_out_count++] = {vector_at(box, "min_m"), vector_at(box, "max_m")};
    }
    return machine;
}

}  // namespace

bool is_sample_trace(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    std::array<char, 8> magic{};
    in.read(magic.data(), magic.size());
    return in.gcount() == static_cast<std::streamsize>(magic.size()) && magic == trace::kSampleMagic;
}

MachineConfig machine_of_trace(const std::filesystem::path& path) {
    const TraceHeader header = read_sample_header(path);
    try {
        return machine_from(Json::parse(header.json));
    } catch (const Json::exception& error) {
        throw InputError({.file = path.string(),
                          .problem = "has a header that does not describe its machine",
                          .value = shortened(error.what()),
                          .action = "run the job again with this version"});
    }
}

MotionTrace read_motion_trace(const std::filesystem::path& path) {
    return is_sample_trace(path) ? read_cell_trace(path) : CsvMotion(path).read();
}

std::vector<Vec3> read_polyline(const std::filesystem::path& path) {
    const CsvTable table = CsvTable::read(path);
    table.refuse_columns_beyond({"x", "y", "z"});
    const std::array<std::size_t, 3> column{table.column("x"), table.column("y"), table.column("z")};
    std::vector<Vec3> points;
    points.reserve(table.size());
    for (std::size_t row = 0; row < table.size(); ++row) {
        std::array<double, 3> v{};
        for (std::size_t i = 0; i < 3; ++i) {
            v[i] = table.number(row, column[i]) / 1e3;
            if (std::abs(v[i]) > kFarthestBase) {
                throw InputError({.file = path.string(),
                                  .line = table.line(row),
                                  .problem = "column " + table.columns()[column[i]] + " is beyond 1000 m",
                                  .value = shortened(table.text(row, column[i])),
                                  .action = "give millimetres"});
            }
        }
        points.push_back({v[0], v[1], v[2]});
    }
    if (points.size() < 2) {
        throw InputError({.file = path.string(),
                          .problem = "holds too few points to be a path",
                          .value = std::to_string(points.size()),
                          .action = "give at least two"});
    }
    return points;
}

}  // namespace sc::host
