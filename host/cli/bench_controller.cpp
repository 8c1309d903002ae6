// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/child_process.hpp"
#include "host/bridge/client.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/key_file.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/program.hpp"
#include "host/bridge/session.hpp"
#include "host/bridge/stop.hpp"
#include "host/calibration/galvo_model.hpp"
#include "host/cli/bench_figures.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/formats/file.hpp"
#include "shared/path/item.hpp"
#include "shared/path/job_hash.hpp"

namespace sc::host::cli {
namespace {

constexpr double kPrrHz = 200e3;
constexpr double kChord = 0.5e-3;    // at 2 m/s: 4 000 points/s
constexpr int kSpiralPoints = 4000;  // 1 s of marking, twice what the queue holds
constexpr int kSplitPoints = 3640;   // lights in turns: they begin with dark and end with light
constexpr double kWireUnits = 1e5;   // a millimetre
const Vec3 kCentreMm{-250.0, -319.0, -390.0};

std::int32_t wire(double mm) { return static_cast<std::int32_t>(std::lround(mm * kWireUnits)); }

PathBegin path(std::uint32_t id, Actuator actuator, std::uint32_t speed_um_s, std::uint32_t pitch_nm) {
    PathBegin begin;
    begin.path = id;
    begin.actuator = actuator;
    begin.speed_um_s = speed_um_s;
    begin.pitch_nm = pitch_nm;
    begin.energy_nj = 300'000;
    begin.tolerance_nm = 10'000;
    begin.anchor_x = wire(kCentreMm.x);
    begin.anchor_y = wire(kCentreMm.y);
    begin.anchor_z = wire(kCentreMm.z);
    return begin;
}

/// Points, and their number.
class Job {
public:
    void begin(const PathBegin& begin) { items_.emplace_back(begin); }
    void point(double x_mm, double z_mm) {
        items_.emplace_back(PathPoint{wire(kCentreMm.x + x_mm), wire(kCentreMm.y), wire(kCentreMm.z + z_mm)});
        ++points_;
    }
    void end() { items_.emplace_back(PathEnd{}); }
    void add(const Item& item) { items_.push_back(item); }
    [[nodiscard]] const std::vector<Item>& items() const { return items_; }
    [[nodiscard]] int points() const { return points_; }

private:
    std::vector<Item> items_;
    int points_ = 0;
};

/// Path 0: the mirrors on a widening spiral at 2 m/s, a pulse each 10 µm, a point each 0.5 mm.
void add_spiral(Job& job) {
    job.begin(path(0, Actuator::galvo, 2'000'000, 10'000));
    double angle = 0.0;
    for (int i = 0; i < kSpiralPoints; ++i) {
        const double radius = 11.0 + 3.0 * i / kSpiralPoints;
        job.point(radius * std::cos(angle), radius * std::sin(angle));
        angle += kChord * 1e3 / radius;
    }
    job.end();
}

/// Path 1: short strokes with sharp corners, so that the speed changes all the time.
void add_zigzag(Job& job) {
    job.begin(path(1, Actuator::galvo, 1'000'000, 10'000));
    for (int i = 0; i < 40; ++i) {
        job.point(-6.0 + 0.3 * i, i % 2 == 0 ? -1.0 : 1.0);
    }
    job.end();
}

/// Path 2: the axes on a wavy line with a point each 50 µm.
void add_dense_line(Job& job) {
    job.begin(path(2, Actuator::axes, 200'000, 20'000));
    for (int i = 0; i < 400; ++i) {
        const double x = 0.05 * i;
        job.point(x, 0.3 * std::sin(x * std::numbers::pi / 5.0));
    }
    job.end();
}

/// Path 3: dense points at 1.9 m/s and a pulse each 10 µm, dark and lit in turns, while the stage goes along: a
/// widening spiral that moves on at 95 mm/s.
void add_split_spiral(Job& job) {
    constexpr double kSpacing = 95.0;  // mm of path: 20 knots a second
    constexpr double kDrift = 0.045;   // of the path's length
    job.begin(path(3, Actuator::split, 1'900'000, 10'000));
    job.add(StageCurve{95'000});
    double angle = 0.0;
    double length = 0.0;
    int knots = 0;
    for (int i = 0; i < kSplitPoints; ++i) {
        const double radius = 11.0 + 3.0 * i / kSplitPoints;
        length += i > 0 ? kChord * 1e3 : 0.0;
        for (; knots < static_cast<int>(std::lround((length + 5.0) / kSpacing)) + 4; ++knots) {
            job.add(
                StageKnot{wire(kCentreMm.x + kDrift * kSpacing * (knots - 1)), wire(kCentreMm.y), wire(kCentreMm.z)});
        }
        job.point(radius * std::cos(angle) + kDrift * length, radius * std::sin(angle));
        angle += kChord * 1e3 / radius;
        if (i % 40 == 20 && i + 40 < kSplitPoints) {
            job.add(PathLight{i % 80 != 20});
        }
    }
    job.end();
}

Job workload(bool split) {
    Job job;
    job.add(Turn{0});
    if (split) {
        add_split_spiral(job);
    } else {
        add_spiral(job);
        add_zigzag(job);
        add_dense_line(job);
    }
    job.add(JobEnd{});
    return job;
}

/// With the field correction of the example: what a tick costs in use.
nlohmann::json run_on(const std::string& board, const Job& job, const CalibrationSet& calibration,
                      const BenchOptions& options, const std::filesystem::path& folder,
                      const std::optional<std::filesystem::path>& record,
                      const std::optional<std::filesystem::path>& key = std::nullopt) {
    std::fprintf(stderr, "running on the board %s\n", board.c_str());
    LinkOptions link;
    link.board = board;
    link.seed = options.seed;
    link.out = folder;
    link.record = record;
    link.key = key;
    link.prr_nominal_hz = kPrrHz;
    double sealed_blocks_per_s = 0.0;
    {
        const auto transport = open_transport("sim:", link);
        CellClient client(*transport, client_options(link, static_cast<std::uint32_t>(options.seed) + 1U));
        client.set_stop_check(stop_requested);
        client.connect();
        sealed_blocks_per_s = client.sealed_blocks_per_s();
        Session session(client, {});
        session.clear();
        client.set_galvo_field(galvo_field_of(calibration));
        static_cast<void>(session.run({job_hash(job.items()), job.items(), 10.0}, nullptr));
    }
    nlohmann::json report = nlohmann::json::parse(read_text_file(folder / "cell.json"));
    report["sealed_blocks_per_s"] = sealed_blocks_per_s;
    return report;
}

nlohmann::json replay(const std::filesystem::path& log, const std::filesystem::path& folder) {
    std::fprintf(stderr, "replaying on this PC\n");
    const std::filesystem::path program = required_program("scribecell-replay");
    // Once for the tables, once without them for the time.
    static_cast<void>(run_program(program, {"--json", "--out", folder.string(), "--", log.string()}));
    const ProgramOutput output = run_program(program, {"--json", "--", log.string()});
    if (output.text.empty()) {
        throw CellError("scribecell-replay ended with code " + std::to_string(output.exit_code) + " and said nothing");
    }
    return nlohmann::json::parse(output.text);
}

/// Pulses a second of path 0, from the replay's table of commands, and points a second from that.
struct Rates {
    double pulses = 0.0;
    double points = 0.0;
};
Rates rates_of(const std::filesystem::path& commands) {
    std::ifstream file(commands);
    std::string line;
    std::getline(file, line);
    double first_ns = 0.0;
    double last_ns = 0.0;
    int pulses = 0;
    while (std::getline(file, line)) {
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream words(line);
        std::array<double, 10> column{};
        for (double& value : column) {
            words >> value;
        }
        if (!words) {
            throw CellError("commands.csv of the replay has a line that is none: " + line);
        }
        if (column[1] == 0.0) {
            first_ns = pulses == 0 ? column[9] : first_ns;
            last_ns = column[9];
            ++pulses;
        }
    }
    if (pulses < 2) {
        throw CellError("the replay commands no pulses");
    }
    const double seconds = (last_ns - first_ns) * 1e-9;
    return {(pulses - 1) / seconds, (kSpiralPoints - 1) / seconds};
}

}  // namespace

std::vector<Figure> bench_controller(const BenchOptions& options) {
    const Job job = workload(false);
    const Job split_job = workload(true);
    const std::optional<std::filesystem::path> root = find_project_root();
    if (!root) {
        throw CellError("the project's files are not beside this program: set SCRIBECELL_ROOT to its folder");
    }
    const CalibrationSet calibration = read_calibration(*root / "examples/ras3dm/calibration.toml");
    const RunFolder folder(options.raw);
    const std::filesystem::path log = folder.path() / "controller.rec";
    const nlohmann::json board = run_on("m7", job, calibration, options, folder.path() / "m7", log);
    const nlohmann::json pc = run_on("sim", job, calibration, options, folder.path() / "sim", std::nullopt);
    const nlohmann::json split =
        run_on("m7", split_job, calibration, options, folder.path() / "m7_split", std::nullopt);
    const nlohmann::json split_pc =
        run_on("sim", split_job, calibration, options, folder.path() / "sim_split", std::nullopt);
    // What seals on the host's messages add.
    const std::filesystem::path key = folder.path() / "cell.key";
    const std::filesystem::path sealed_log = folder.path() / "sealed.rec";
    std::filesystem::remove(key);
    static_cast<void>(make_key_file(key));
    const nlohmann::json sealed =
        run_on("m7", split_job, calibration, options, folder.path() / "m7_sealed", sealed_log, key);
    const ProgramOutput sealed_again =
        run_program(required_program("scribecell-replay"), {"--key", key.string(), "--", sealed_log.string()});
    const nlohmann::json again = replay(log, folder.path() / "replay");
    const Rates rates = rates_of(folder.path() / "replay" / "commands.csv");
    const nlohmann::json& all = board.at("figures").at("instructions");
    const nlohmann::json& marking = board.at("figures").at("instructions_marking");
    const auto hash_of = [](const nlohmann::json& run) { return run.at("command_trace_sha256").get<std::string>(); };
    const bool hashes_equal = hash_of(board) == hash_of(pc) && hash_of(board) == hash_of(again) &&
                              hash_of(split) == hash_of(split_pc) && hash_of(split) == hash_of(sealed);
    const nlohmann::json& split_marking = split.at("figures").at("instructions_marking");
    const nlohmann::json& sealed_marking = sealed.at("figures").at("instructions_marking");
    const auto count = [](const nlohmann::json& figures, const char* name) {
        return figures.at(name).at("count").get<double>();
    };
    const auto plan_per_tick = [](const nlohmann::json& run) {
        const nlohmann::json& marked = run.at("figures").at("instructions_marking");
        return marked.at("plan_total").get<double>() / marked.at("ticks").get<double>();
    };
    return {{"servo_instructions_max", count(marking, "servo_max"), ""},
            {"servo_instructions_max_any", count(all, "servo_max"), ""},
            {"plan_instructions_per_point", all.at("plan_total").get<double>() / job.points(), ""},
            {"tick_instructions_max", count(marking, "tick_max"), ""},
            {"split_servo_instructions_max", count(split_marking, "servo_max"), ""},
            {"split_tick_instructions_max", count(split_marking, "tick_max"), ""},
            {"sealed_blocks_per_s", sealed.at("sealed_blocks_per_s").get<double>(), "1/s"},
            {"sealed_servo_instructions_max", count(sealed_marking, "servo_max"), ""},
            {"sealed_tick_instructions_max", count(sealed_marking, "tick_max"), ""},
            {"sealed_plan_instructions_added", plan_per_tick(sealed) - plan_per_tick(split), ""},
            {"sealed_replay_equal", sealed_again.exit_code == 0 ? 1.0 : 0.0, ""},
            {"points_per_s", rates.points, "1/s"},
            {"pulses_per_s", rates.pulses, "1/s"},
            {"hashes_equal", hashes_equal ? 1.0 : 0.0, ""},
            {"replay_equal", again.at("equal").get<bool>() ? 1.0 : 0.0, ""},
            {"pc_ticks_per_s", again.at("ticks_per_s").get<double>(), "1/s"}};
}

}  // namespace sc::host::cli
