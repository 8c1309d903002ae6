// SPDX-License-Identifier: Apache-2.0
#include "host/cli/bench_split.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "host/bridge/child_process.hpp"
#include "host/bridge/client.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/session.hpp"
#include "host/bridge/stop.hpp"
#include "host/calibration/galvo_model.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/file.hpp"
#include "host/formats/pulse_trace.hpp"
#include "host/path/split_path.hpp"
#include "host/verification/motion_trace.hpp"
#include "host/verification/sample_checker.hpp"
#include "shared/path/job_hash.hpp"

namespace sc::host::cli {
namespace {

constexpr double kTile = 50e-3;
constexpr int kColumns = 6;
constexpr int kRows = 10;
constexpr Vec3 kFirstTile{-350e-3, -210e-3, -454.5e-3};  ///< centre
constexpr double kSpeed = 1.0;                           ///< m/s: 50 mm of line are 0.05 s of marking
constexpr double kPitch = 100e-6;
constexpr double kPrrHz = 40e3;
constexpr std::uint32_t kToleranceNm = 1000;

struct Tile {
    int column = 0;
    int row = 0;
    [[nodiscard]] Vec3 centre() const { return kFirstTile + Vec3{kTile * column, 0.0, kTile * row}; }
};

/// Row by row, to and fro: each move of the stage is one tile.
std::vector<Tile> serpentine() {
    std::vector<Tile> tiles;
    for (int row = 0; row < kRows; ++row) {
        for (int i = 0; i < kColumns; ++i) {
            tiles.push_back({row % 2 == 0 ? i : kColumns - 1 - i, row});
        }
    }
    return tiles;
}

/// Two rows at once, as far as the field goes: the stage moves half as far. At both ends of such a strip two columns
/// are done in turns, so that there is time to move on to the next strip.
std::vector<Tile> strips() {
    constexpr std::array<std::pair<int, int>, 2 * kColumns> kOrder{
        {{1, 0}, {0, 0}, {0, 1}, {1, 1}, {2, 1}, {2, 0}, {3, 0}, {3, 1}, {4, 0}, {5, 0}, {5, 1}, {4, 1}}};
    std::vector<Tile> tiles;
    for (int strip = 0; strip < kRows / 2; ++strip) {
        for (const auto& [i, level] : kOrder) {
            tiles.push_back({strip % 2 == 0 ? i : kColumns - 1 - i, 2 * strip + level});
        }
    }
    return tiles;
}

/// Lines along z over the whole tile, to and fro, from the corner of the tile that is nearest to `at`, where they end.
std::vector<Stroke3> strokes_of(const Tile& tile, int lines, Vec3& at) {
    std::vector<Stroke3> strokes;
    const Vec3 c = tile.centre();
    const double half = 0.5 * kTile;
    const double across = at.x <= c.x ? 1.0 : -1.0;
    const double up = at.z <= c.z ? 1.0 : -1.0;
    for (int i = 0; i < lines; ++i) {
        const double x = c.x + across * (kTile * (i + 0.5) / lines - half);
        const double way = i % 2 == 0 ? up : -up;
        strokes.push_back({{{x, c.y, c.z - way * half}, {x, c.y, c.z + way * half}, std::nullopt, 0}});
        at = strokes.back().front().to;
    }
    return strokes;
}

PathBegin path_begin(Actuator actuator, std::uint32_t id, const Vec3& anchor) {
    const auto wire = [](double metres) {
        return static_cast<std::int32_t>(std::llround(metres * kWireUnitsPerMetre));
    };
    return {.path = id,
            .actuator = actuator,
            .pass = 0,
            .speed_um_s = static_cast<std::uint32_t>(kSpeed * 1e6),
            .pitch_nm = static_cast<std::uint32_t>(kPitch * 1e9),
            .energy_nj = 300'000,
            .tolerance_nm = kToleranceNm,
            .anchor_x = wire(anchor.x),
            .anchor_y = wire(anchor.y),
            .anchor_z = wire(anchor.z)};
}

struct TileJob {
    std::vector<Item> items{Turn{0}};
    std::vector<Stroke3> strokes;  ///< in the order in which they are marked
};

TileJob step_and_scan(const std::vector<Tile>& tiles, int lines, const MachineConfig& machine) {
    TileJob job;
    std::uint32_t id = 0;
    Vec3 at = tiles.front().centre();
    for (const Tile& tile : tiles) {
        const std::vector<Stroke3> strokes = strokes_of(tile, lines, at);
        const StrokePath path = stroke_path(path_begin(Actuator::galvo, id++, tile.centre()), strokes, machine);
        job.items.insert(job.items.end(), path.items.begin(), path.items.end());
        job.strokes.insert(job.strokes.end(), strokes.begin(), strokes.end());
    }
    job.items.emplace_back(JobEnd{});
    return job;
}

TileJob split(const std::vector<Tile>& tiles, int lines, const MachineConfig& machine) {
    TileJob job;
    Vec3 at = tiles.front().centre();
    for (const Tile& tile : tiles) {
        const std::vector<Stroke3> strokes = strokes_of(tile, lines, at);
        job.strokes.insert(job.strokes.end(), strokes.begin(), strokes.end());
    }
    const StrokePath path = split_path(path_begin(Actuator::split, 0, {}), job.strokes, machine);
    const double speed = std::get<PathBegin>(path.items.front()).speed_um_s * 1e-6;
    std::fprintf(stderr, "stage's curve: %.3f of its rules, %zu control points, %.2f m of path at %.3f m/s\n",
                 path.stage.worst, path.stage.control.size(), path.length, speed);
    if (path.stage.worst > 1.0 + kStageSlack) {
        throw CellError(
            fmt::format("there is no curve for the stage at {} lines a tile: {:.2f} of its rules at {:.3f} m", lines,
                        path.stage.worst, path.stage.worst_distance));
    }
    job.items.insert(job.items.end(), path.items.begin(), path.items.end());
    job.items.emplace_back(JobEnd{});
    return job;
}

struct TileRun {
    double seconds = 0.0;  ///< from the first pulse to the last
    double placement_rms = 0.0;
    double placement_peak = 0.0;
    std::size_t lost = 0;
    std::uint64_t violations = 0;
};

/// Pulse by pulse against the lines as they were given; the mean is where the axes stand off.
void judge_places(const TileJob& job, const std::vector<trace::PulseRecord>& pulses, TileRun& run) {
    std::size_t due = 0;
    for (const Stroke3& stroke : job.strokes) {
        due += static_cast<std::size_t>(std::floor(length(stroke) / kPitch + 1e-6)) + 1;
    }
    run.lost = due > pulses.size() ? due - pulses.size() : pulses.size() - due;
    if (run.lost > 0) {
        return;
    }
    std::vector<Vec3> off;
    std::size_t next = 0;
    Vec3 mean{};
    for (const Stroke3& stroke : job.strokes) {
        const double whole = length(stroke);
        const auto count = static_cast<std::size_t>(std::floor(whole / kPitch + 1e-6)) + 1;
        for (std::size_t k = 0; k < count; ++k) {
            const trace::PulseRecord& pulse = pulses[next++];
            const Vec3 place{static_cast<double>(pulse.place_pm[0]) * 1e-12, 0.0,
                             static_cast<double>(pulse.place_pm[2]) * 1e-12};
            const Vec3 at = stroke.front().at(static_cast<double>(k) * kPitch / whole);
            off.push_back(place - Vec3{at.x, 0.0, at.z});
            mean = mean + off.back();
        }
    }
    mean = (1.0 / static_cast<double>(off.size())) * mean;
    double square = 0.0;
    for (const Vec3& o : off) {
        const double distance = norm(o - mean);
        square += distance * distance;
        run.placement_peak = std::max(run.placement_peak, distance);
    }
    run.placement_rms = std::sqrt(square / static_cast<double>(off.size()));
}

class TileBench {
public:
    explicit TileBench(const BenchOptions& options) : options_(options), folder_(options.raw) {
        const auto root = find_project_root();
        if (!root) {
            throw CellError(
                "the bench's world is not beside this program: set SCRIBECELL_ROOT to the project's folder");
        }
        link_.world = *root / "boards/sim/world/beam/wide.toml";
        link_.seed = options.seed;
        link_.prr_nominal_hz = kPrrHz;
        link_.machine = {"galvo.word=18"};
        nominal_.value[GalvoModel::kF1] = nominal_.angle_scale;
        nominal_.value[GalvoModel::kExitX] = nominal_.value[GalvoModel::kExitZ] = 1.0 / nominal_.angle_scale;
    }

    TileRun run(const std::string& name, const TileJob& job) {
        std::fprintf(stderr, "marking 60 tiles: %s\n", name.c_str());
        LinkOptions link = link_;
        link.out = folder_.path() / name;
        {
            const auto transport = open_transport("sim:", link);
            CellClient client(*transport, {.session = static_cast<std::uint32_t>(options_.seed) + 1U});
            client.set_stop_check(stop_requested);
            client.connect();
            Session session(client, {});
            session.clear();
            client.set_galvo_field(nominal_.field());
            static_cast<void>(session.run({job_hash(job.items), job.items, 60.0}, nullptr));
        }
        TileRun run;
        const std::vector<trace::PulseRecord> pulses = read_pulse_trace(*link.out / "pulses.trace").pulses;
        run.seconds = pulses.empty() ? 0.0 : 1e-9 * static_cast<double>(pulses.back().t_ns - pulses.front().t_ns);
        judge_places(job, pulses, run);
        const std::filesystem::path samples = *link.out / "samples.trace";
        run.violations = check_samples(samples, machine_of_trace(samples)).limit_violations;
        table_ += fmt::format("{},{:.6f},{:.4f},{:.4f},{},{}\n", name, run.seconds, run.placement_rms * 1e6,
                              run.placement_peak * 1e6, run.lost, run.violations);
        return run;
    }
    void write() const {
        if (options_.raw) {
            write_text_file(folder_.path() / "tiles.csv",
                            "run,seconds,placement_rms_um,placement_peak_um,lost,violations\n" + table_);
        }
    }

private:
    BenchOptions options_;
    RunFolder folder_;
    LinkOptions link_;
    GalvoModel nominal_;
    std::string table_;
};

}  // namespace

std::vector<Figure> bench_split(const BenchOptions& options) {
    const MachineConfig machine = reference_machine();
    TileBench bench(options);
    std::vector<Figure> figures;
    TileRun worst;
    std::size_t lost = 0;
    for (const auto& [lines, name] : {std::pair{2, "0_1s"}, std::pair{6, ""}, std::pair{20, "1s"}}) {
        const std::string suffix = *name == '\0' ? std::string() : "_" + std::string(name);
        const TileRun stepped = bench.run("step_and_scan" + suffix, step_and_scan(serpentine(), lines, machine));
        const TileRun both = bench.run("split" + suffix, split(strips(), lines, machine));
        figures.push_back({"split_speedup" + suffix, stepped.seconds / both.seconds, ""});
        worst.violations += both.violations + stepped.violations;
        lost += both.lost + stepped.lost;
        if (suffix.empty()) {
            worst.placement_rms = both.placement_rms;
            worst.placement_peak = both.placement_peak;
            const TileRun off = bench.run("split_off", step_and_scan(strips(), lines, machine));
            figures.push_back({"split_off_speedup", stepped.seconds / off.seconds, ""});
        }
    }
    bench.write();
    figures.push_back({"split_limit_violations", static_cast<double>(worst.violations), ""});
    figures.push_back({"split_pulses_lost", static_cast<double>(lost), ""});
    figures.push_back({"split_placement_rms_um", worst.placement_rms * 1e6, "um"});
    figures.push_back({"split_placement_peak_um", worst.placement_peak * 1e6, "um"});
    return figures;
}

}  // namespace sc::host::cli
