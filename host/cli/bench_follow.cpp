// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "host/bridge/errors.hpp"
#include "host/cli/bench_pulses.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

constexpr double kWireUnits = 1e5;  // a millimetre
constexpr Vec3 kCentreMm{-225.0, -210.0, -250.0};
constexpr double kHalfMm = 20.0;
constexpr double kPrrHz = 80e3;
constexpr double kPitchMm = 0.02;

/// A path of the axes, there along x and back along z: 2 s each, forty swings of the disturbance.
struct Line {
    double dx = 0.0;
    double dz = 0.0;
};
constexpr std::array<Line, 2> kLines{Line{1.0, 0.0}, Line{0.0, 1.0}};

std::vector<Item> items() {
    const auto wire = [](double mm) { return static_cast<std::int32_t>(std::lround(mm * kWireUnits)); };
    std::vector<Item> out{Turn{0}};
    std::uint32_t path = 0;
    for (const Line& line : kLines) {
        PathBegin begin;
        begin.path = path++;
        begin.actuator = Actuator::axes;
        begin.speed_um_s = 20'000;
        begin.pitch_nm = static_cast<std::uint32_t>(std::lround(kPitchMm * 1e6));
        begin.energy_nj = 300'000;
        begin.tolerance_nm = 10'000;
        out.emplace_back(begin);
        for (const double way : {-1.0, 1.0}) {
            out.emplace_back(PathPoint{wire(kCentreMm.x + way * kHalfMm * line.dx), wire(kCentreMm.y),
                                       wire(kCentreMm.z + way * kHalfMm * line.dz)});
        }
        out.emplace_back(PathEnd{});
    }
    out.emplace_back(JobEnd{});
    return out;
}

/// Root mean square of what the pulses are off their places on the workpiece, about each line's mean; x and z. Metres.
std::array<double, 2> off_path(const std::vector<trace::PulseRecord>& pulses) {
    constexpr std::int64_t kPauseNs = 100'000'000;
    std::vector<std::vector<std::array<double, 2>>> lines;
    std::int64_t last = 0;
    for (const trace::PulseRecord& pulse : pulses) {
        if (lines.empty() || pulse.t_ns - last > kPauseNs) {
            lines.emplace_back();
        }
        last = pulse.t_ns;
        const double s = kPitchMm * 1e-3 * static_cast<double>(lines.back().size());
        const Line& way = kLines.at(std::min(lines.size(), kLines.size()) - 1);
        lines.back().push_back({static_cast<double>(pulse.table_pm[0]) * 1e-12 - s * way.dx,
                                static_cast<double>(pulse.table_pm[2]) * 1e-12 - s * way.dz});
    }
    const auto expected = static_cast<std::size_t>(std::lround(2.0 * kHalfMm / kPitchMm)) + 1;
    std::array<double, 2> sum{};
    std::size_t count = 0;
    for (const auto& line : lines) {
        if (lines.size() != kLines.size() || line.size() != expected) {
            throw CellError("the axes' lines have pulses missing or too many");
        }
        std::array<double, 2> mean{};
        for (const auto& p : line) {
            mean[0] += p[0] / static_cast<double>(line.size());
            mean[1] += p[1] / static_cast<double>(line.size());
        }
        for (const auto& p : line) {
            sum[0] += (p[0] - mean[0]) * (p[0] - mean[0]);
            sum[1] += (p[1] - mean[1]) * (p[1] - mean[1]);
        }
        count += line.size();
    }
    return {std::sqrt(sum[0] / static_cast<double>(count)), std::sqrt(sum[1] / static_cast<double>(count))};
}

}  // namespace

std::vector<Figure> bench_follow(const BenchOptions& options) {
    const RunFolder folder(options.raw);
    const std::vector<Item> job = items();
    std::string table = "world,mirrors,rms_x_um,rms_z_um\n";
    const auto run = [&](const char* world, const char* follow) {
        const std::string name = std::string(world) + "_" + follow;
        std::fprintf(stderr, "axes that are pushed: %s\n", name.c_str());
        const auto rms =
            off_path(burn_pulses(job,
                                 {.world = beam_world(std::string(world) + ".toml"),
                                  .machine = {"axis.encoder_um=0.1", std::string("galvo.follow=") + follow},
                                  .prr_hz = kPrrHz,
                                  .seed = options.seed},
                                 folder.path() / name));
        table += fmt::format("{},{},{:.4f},{:.4f}\n", world, follow, rms[0] * 1e6, rms[1] * 1e6);
        return rms;
    };
    const auto linear_off = run("pushed_axes", "off");
    const auto turn_off = run("pushed_table", "off");
    const auto cancelled = [&](const char* follow) {
        const auto linear = run("pushed_axes", follow);
        const auto turn = run("pushed_table", follow);
        return std::array{100.0 * (1.0 - linear[0] / linear_off[0]), 100.0 * (1.0 - linear[1] / linear_off[1]),
                          100.0 * (1.0 - turn[0] / turn_off[0])};
    };
    const auto direct = cancelled("encoders");
    const auto drives = cancelled("drives");
    if (options.raw) {
        write_text_file(folder.path() / "follow.csv", table);
    }
    return {{"following_error_rms_um", linear_off[0] * 1e6, "um"},
            {"following_error_c_rms_um", turn_off[0] * 1e6, "um"},
            {"following_error_cancelled_pct", std::min(direct[0], direct[1]), "%"},
            {"following_error_c_cancelled_pct", direct[2], "%"},
            {"following_error_cancelled_pdo_pct", std::min(drives[0], drives[1]), "%"},
            {"following_error_c_cancelled_pdo_pct", drives[2], "%"}};
}

}  // namespace sc::host::cli
