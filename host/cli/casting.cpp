// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <ranges>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/inspect_lines.hpp"
#include "host/cli/progress_printer.hpp"
#include "host/cli/run_folder.hpp"
#include "host/cli/scribe_output.hpp"
#include "host/cli/scribe_run.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/mesh.hpp"
#include "host/formats/pulse_trace.hpp"
#include "host/formats/scan.hpp"
#include "host/inspection/inspection.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell casting
      a casting at a random pose: scanned, inspected, borrowed, its datum lines burnt and measured
  scribecell casting --seed 7 --out run7
      another pose; everything that was made stays in run7
  scribecell casting --json
      one JSON object

Exit codes: 0 burnt; 1 the cell or the job failed; 2 bad input.)";

constexpr double kViewSeconds = 25.0;       ///< of a sensor and its robot, a view: modelled, not measured
constexpr std::int64_t kDark = 20'000'000;  ///< ns without a pulse between two stretches
constexpr std::ptrdiff_t kWorst = 5;        ///< stretches named in the JSON
constexpr double kTableY = -0.3300281;      ///< metres: the table stands nearer than for the example's large casting

struct Words {
    std::uint64_t seed = 1;
    std::optional<std::string> out;
    std::string board = "sim";
    bool json = false;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::filesystem::path project() {
    const auto root = find_project_root();
    if (!root) {
        throw InputError({.file = {},
                          .problem = "the casting's files are not beside this program",
                          .value = {},
                          .action = "set SCRIBECELL_ROOT to the project's folder"});
    }
    return *root;
}

/// The example cell's calibration, with its table where this casting can be reached.
CalibrationSet calibration_at(const std::filesystem::path& root, const std::filesystem::path& file) {
    CalibrationSet set = read_calibration(root / "examples/ras3dm/calibration.toml");
    set.turntable->line.point.v.y = kTableY;
    set.id = "casting-cell";
    write_calibration(file, set);
    return read_calibration(file);
}

std::vector<std::string> scanner_words(const std::filesystem::path& root, const std::filesystem::path& out,
                                       const CalibrationSet& set, std::uint64_t seed) {
    const auto& h_from_c = *std::ranges::find(set.transforms, "h_from_c", &TransformRecord::id);
    std::string pose;
    for (const Vec3& row : h_from_c.rotation.row) {
        pose += fmt::format("{:.12f},{:.12f},{:.12f},", row.x, row.y, row.z);
    }
    const Vec3 t = 1e3 * h_from_c.translation;
    pose += fmt::format("{:.7f},{:.7f},{:.7f}", t.x, t.y, t.z);
    const Vec3 at = 1e3 * set.turntable->line.point.v;
    const Vec3& way = set.turntable->line.direction.v;
    return {"--base",
            (root / "boards/sim/world/default/world.toml").string(),
            "--casting",
            (root / "tests/data/casting-blank/rough.stl").string(),
            "--out",
            out.string(),
            "--seed",
            std::to_string(seed),
            "--h-from-c=" + pose,
            fmt::format("--axis={:.7f},{:.7f},{:.7f},{:.12f},{:.12f},{:.12f}", at.x, at.y, at.z, way.x, way.y, way.z)};
}

/// Distances of all pulses from the true datum planes, metres, and how many met nothing.
struct Burnt {
    std::vector<double> off;
    std::size_t missed = 0;
    struct Worst {
        double off = 0.0;
        std::string datum;
        Vec3 place;  ///< in w of the blank as it was scanned and moved
    };
    std::vector<Worst> worst;  ///< of each stretch, the farthest first
    [[nodiscard]] double share(double part) const {
        const auto last = static_cast<double>(off.size() - 1);
        return off.empty() ? 0.0 : off[static_cast<std::size_t>(std::lround(part * last))];
    }
};
/// Distances of pulses that were burnt in one go: all from the one plane that most of them lie on.
void add_stretch(std::span<const Vec3> stretch, std::span<const DatumLine> lines, Burnt& out) {
    std::vector<double> best;
    std::string datum;
    double least = std::numeric_limits<double>::infinity();
    for (const DatumLine& line : lines) {
        std::vector<double> here;
        for (const Vec3& place : stretch) {
            here.push_back(std::abs(line.plane.height(place)));
        }
        std::vector<double> order = here;
        const auto middle = order.begin() + static_cast<std::ptrdiff_t>(order.size() / 2);
        std::ranges::nth_element(order, middle);
        if (middle != order.end() && *middle < least) {
            least = *middle;
            best = std::move(here);
            datum = line.id;
        }
    }
    if (!best.empty()) {
        const auto farthest = std::ranges::max_element(best);
        out.worst.push_back({*farthest, datum, stretch[static_cast<std::size_t>(farthest - best.begin())]});
        out.off.insert(out.off.end(), best.begin(), best.end());
    }
}

Burnt measure(const std::filesystem::path& folder, const std::filesystem::path& run, const Inspection& inspection) {
    const auto truth = nlohmann::json::parse(read_text_file(folder / "truth.json")).at("t_from_w");
    Rigid<frame::T, frame::W> t_from_w;
    const auto vec = [](const nlohmann::json& v) {
        return Vec3{v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>()};
    };
    for (std::size_t i = 0; i < 3; ++i) {
        t_from_w.rotation.row[i] = vec(truth.at("rotation").at(i));
    }
    t_from_w.translation = 1e-3 * vec(truth.at("translation_mm"));
    // The scanned part was moved in w by the borrowing: a datum lies where that motion is undone.
    const Rigid<frame::W, frame::W> motion =
        inspection.borrowing ? inspection.borrowing->motion : Rigid<frame::W, frame::W>{};
    const auto w_from_t = motion * t_from_w.inverse();
    Burnt out;
    std::vector<Vec3> stretch;
    std::int64_t last = 0;
    for (const trace::PulseRecord& pulse : read_pulse_trace(run / "pulses.trace").pulses) {
        if (pulse.hit == 0) {
            ++out.missed;
            continue;
        }
        const Vec3 table{1e-12 * static_cast<double>(pulse.table_pm[0]), 1e-12 * static_cast<double>(pulse.table_pm[1]),
                         1e-12 * static_cast<double>(pulse.table_pm[2])};
        if (pulse.t_ns - last > kDark) {
            add_stretch(stretch, inspection.lines, out);
            stretch.clear();
        }
        last = pulse.t_ns;
        stretch.push_back(w_from_t.rotation * table + w_from_t.translation);
    }
    add_stretch(stretch, inspection.lines, out);
    std::ranges::sort(out.off);
    std::ranges::sort(out.worst, std::greater{}, &Burnt::Worst::off);
    return out;
}

struct Stages {
    double make = 0.0;  ///< of the simulation itself
    double inspect = 0.0;
    double burn = 0.0;  ///< of the cell's time
    std::size_t views = 0;
};

void print(const Words& words, const Inspection& inspection, const LineJob& lines, const ScribeOutcome& burnt,
           const Burnt& found, const Stages& stages) {
    const double scan = kViewSeconds * static_cast<double>(stages.views);
    const AllowanceReport& verdict = inspection.after ? *inspection.after : inspection.before;
    if (words.json) {
        auto worst = nlohmann::ordered_json::array();
        for (const Burnt::Worst& w : found.worst | std::views::take(kWorst)) {
            worst.push_back({{"datum", w.datum},
                             {"off_um", 1e6 * w.off},
                             {"place_mm", {1e3 * w.place.x, 1e3 * w.place.y, 1e3 * w.place.z}}});
        }
        const nlohmann::ordered_json out{{"seed", words.seed},
                                         {"points", inspection.points},
                                         {"enough", verdict.enough()},
                                         {"least_margin_mm", 1e3 * verdict.least_margin},
                                         {"line_job", line_job_json(lines)},
                                         {"pulses", found.off.size()},
                                         {"missed_pulses", found.missed},
                                         {"burnt_50_um", 1e6 * found.share(0.5)},
                                         {"burnt_95_um", 1e6 * found.share(0.95)},
                                         {"burnt_max_um", 1e6 * found.share(1.0)},
                                         {"worst", std::move(worst)},
                                         {"limit_violations", burnt.report->samples.limit_violations},
                                         {"board", words.board},
                                         {"command_trace_sha256", burnt.report->run.command_trace_sha256},
                                         {"scan_s_modelled", scan},
                                         {"inspect_s", stages.inspect},
                                         {"burn_s", stages.burn}};
        std::printf("%s\n", out.dump(2).c_str());
        return;
    }
    std::printf("casting at the pose of seed %llu: %zu points in %zu views; %s, smallest margin %.3f mm\n",
                static_cast<unsigned long long>(words.seed), inspection.points, stages.views,
                verdict.enough() ? "metal everywhere" : "NOT enough metal", 1e3 * verdict.least_margin);
    std::printf("%.1f mm of datum lines burnt in %zu paths, %.1f mm not reached\n", 1e3 * lines.burnt_length,
                lines.burnt.size(), 1e3 * lines.missed_length);
    std::printf(
        "%zu pulses; distance from the true datum plane: half within %.1f um, 95 %% within %.1f um, all within "
        "%.1f um; %zu met nothing\n",
        found.off.size(), 1e6 * found.share(0.5), 1e6 * found.share(0.95), 1e6 * found.share(1.0), found.missed);
    std::fputs(board_text(burnt).c_str(), stdout);
    std::printf("\n%-34s %10s %12s\n", "stage", "here", "the paper");
    std::printf("%-34s %8.1f s %10s\n", "scan (modelled, 25 s a view)", scan, "10 min");
    std::printf("%-34s %8.1f s %10s\n", "inspection, borrowing, lines", stages.inspect, "3 min");
    std::printf("%-34s %8.1f s %10s\n", "burning (the cell's time)", stages.burn, "5 min");
    std::printf("%-34s %8.1f s %10s; a fitter: 90 min\n", "all", scan + stages.inspect + stages.burn, "18 min");
}

int run(const Words& words) {
    ProgressPrinter printer(stderr_is_terminal());
    const auto say = [&](const std::string& text) { printer.step(text); };
    const std::filesystem::path root = project();
    const RunFolder folder(words.out ? std::optional<std::filesystem::path>(*words.out) : std::nullopt);
    const std::filesystem::path calibration = folder.path() / "calibration.toml";
    const CalibrationSet set = calibration_at(root, calibration);
    Stages stages;
    say("placing and scanning the casting");
    auto start = std::chrono::steady_clock::now();
    const ProgramOutput scanner =
        run_program(required_program("scribecell-scanner"), scanner_words(root, folder.path(), set, words.seed));
    if (scanner.exit_code != 0) {
        throw CellError("scribecell-scanner ended with " + std::to_string(scanner.exit_code));
    }
    stages.views = nlohmann::json::parse(scanner.text).at("views").get<std::size_t>();
    stages.make = seconds_since(start);
    start = std::chrono::steady_clock::now();
    const std::filesystem::path data = root / "tests/data/casting-blank";
    const Part part = read_part(root / "examples/casting/part.toml");
    const DistanceField field(read_mesh(data / "finished.stl").mesh);
    const ScanFile scan = read_scan(folder.path() / "scan.ply");
    InspectionRequest request;
    request.lines = true;
    request.progress = [&](std::string_view step) { say(std::string(step)); };
    const Inspection inspection = inspect(field, scan.cloud.points, &part, request);
    LineFiles files{.folder = folder.path(), .calibration = calibration, .faces = {}, .incidence_deg = 60.0};
    for (int i = -3; i <= 4; ++i) {
        files.faces.push_back(45.0 * i);
    }
    const std::optional<LineJob> lines = write_lines(inspection, scan.cloud.points, files);
    stages.inspect = seconds_since(start);
    ScribeOptions options;
    options.job = folder.path() / "job.toml";
    options.link_options.world = folder.path() / "world.toml";
    options.link_options.out = folder.path() / "run";
    options.link_options.seed = words.seed;
    options.link_options.board = words.board;
    const ScribeOutcome burnt = run_scribe(options);
    if (burnt.failure) {
        print_failure(*burnt.failure);
        return burnt.failure->exit_code;
    }
    stages.burn = burnt.cell_seconds;
    const Burnt found = measure(folder.path(), folder.path() / "run", inspection);
    print(words, inspection, *lines, burnt, found, stages);
    return burnt.report->samples.limit_violations > 0 || found.missed > 0 ? kFailed : kDone;
}

}  // namespace

void add_casting(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("casting", "From a casting to its datum lines, on the simulated cell.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("--seed", words->seed, "of the casting's pose and of all noise")->capture_default_str();
    sub->add_option("--out", words->out, "folder for everything that is made (default: nothing is kept)")
        ->type_name("DIR");
    sub->add_option("--board", words->board, "where the controller runs")
        ->check(CLI::IsMember({"sim", "m7"}))
        ->capture_default_str();
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
