// SPDX-License-Identifier: Apache-2.0
#include "host/cli/casting_run.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/cli/inspect_lines.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/mesh.hpp"
#include "host/formats/pulse_trace.hpp"
#include "host/formats/scan.hpp"

namespace sc::host::cli {
namespace {

constexpr std::int64_t kDark = 20'000'000;  ///< ns without a pulse between two stretches
constexpr double kTableY = -0.3300281;      ///< metres: the table stands nearer than for the example's large casting

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

}  // namespace

CastingRun run_casting(const std::filesystem::path& folder, const CastingOptions& options) {
    const auto& say = options.say;
    const std::filesystem::path root = project();
    const std::filesystem::path calibration = folder / "calibration.toml";
    CastingRun out;
    const CalibrationSet set = calibration_at(root, calibration);
    say("placing and scanning the casting");
    const ProgramOutput scanner =
        run_program(required_program("scribecell-scanner"), scanner_words(root, folder, set, options.seed));
    if (scanner.exit_code != 0) {
        throw CellError("scribecell-scanner ended with " + std::to_string(scanner.exit_code));
    }
    out.views = nlohmann::json::parse(scanner.text).at("views").get<std::size_t>();
    const auto start = std::chrono::steady_clock::now();
    const std::filesystem::path data = root / "tests/data/casting-blank";
    const Part part = read_part(root / "examples/casting/part.toml");
    const DistanceField field(read_mesh(data / "finished.stl").mesh);
    const ScanFile scan = read_scan(folder / "scan.ply");
    InspectionRequest request;
    request.lines = true;
    request.progress = [&](std::string_view step) { say(std::string(step)); };
    out.inspection = inspect(field, scan.cloud.points, &part, request);
    LineFiles files{
        .folder = folder, .calibration = calibration, .faces = {}, .incidence_deg = 60.0, .plain = options.plain};
    for (int i = -3; i <= 4; ++i) {
        files.faces.push_back(45.0 * i);
    }
    const std::optional<LineJob> lines = write_lines(out.inspection, scan.cloud.points, files);
    out.inspect_seconds = seconds_since(start);
    ScribeOptions scribe;
    scribe.job = folder / "job.toml";
    scribe.link_options.world = folder / "world.toml";
    scribe.link_options.out = folder / "run";
    scribe.link_options.seed = options.seed;
    scribe.link_options.board = options.board;
    out.lines = *lines;
    out.scribed = run_scribe(scribe);
    out.burn_seconds = out.scribed.cell_seconds;
    if (!out.scribed.failure) {
        out.burnt = measure(folder, folder / "run", out.inspection);
    }
    return out;
}

}  // namespace sc::host::cli
