// SPDX-License-Identifier: Apache-2.0
#include "host/cli/bench_pulses.hpp"

#include <cmath>

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
#include "host/verification/pulse_checker.hpp"
#include "shared/path/item.hpp"
#include "shared/path/job_hash.hpp"

namespace sc::host::cli {
namespace {

constexpr double kWireUnits = 1e5;  // a millimetre
constexpr Vec3 kCentreMm{-225.0, -210.0, -250.0};
constexpr double kDriftPrrHz = 200e3;
constexpr std::uint32_t kArcToleranceNm = 10'000;
/// No corner is cut, so each pulse of a path of lines has a place of its own: the mirrors come to rest in it.
constexpr std::uint32_t kExactNm = 50;
constexpr int kDriftPulses = 1'000'000;

std::int32_t wire(double mm) { return static_cast<std::int32_t>(std::lround(mm * kWireUnits)); }
PathPoint at(double x_mm, double z_mm) {
    return {wire(kCentreMm.x + x_mm), wire(kCentreMm.y), wire(kCentreMm.z + z_mm)};
}

/// Items of a job, a path at a time; places in mm about the field's centre.
class PulseJob {
public:
    explicit PulseJob(std::uint32_t pitch_nm, std::uint32_t energy_nj) : pitch_nm_(pitch_nm), energy_nj_(energy_nj) {
        items_.emplace_back(Turn{0});
    }
    std::uint32_t begin(double speed_m_s, double x, double z, std::uint32_t tolerance_nm = kArcToleranceNm) {
        PathBegin begin;
        begin.path = paths_;
        begin.actuator = Actuator::galvo;
        begin.speed_um_s = static_cast<std::uint32_t>(std::lround(speed_m_s * 1e6));
        begin.pitch_nm = pitch_nm_;
        begin.energy_nj = energy_nj_;
        begin.tolerance_nm = tolerance_nm;
        begin.anchor_x = wire(kCentreMm.x);
        begin.anchor_y = wire(kCentreMm.y);
        begin.anchor_z = wire(kCentreMm.z);
        items_.emplace_back(begin);
        items_.emplace_back(at(x, z));
        return paths_++;
    }
    void line(double x, double z) { items_.emplace_back(at(x, z)); }
    void arc(double via_x, double via_z, double x, double z) {
        items_.emplace_back(PathArc{at(via_x, via_z), at(x, z)});
    }
    void end() { items_.emplace_back(PathEnd{}); }
    [[nodiscard]] std::vector<Item> items() const {
        std::vector<Item> all = items_;
        all.emplace_back(JobEnd{});
        return all;
    }

private:
    std::uint32_t pitch_nm_;
    std::uint32_t energy_nj_;
    std::uint32_t paths_ = 0;
    std::vector<Item> items_;
};

/// Whole turns of a circle about the centre, `way` +1 or −1.
void circle(PulseJob& job, double speed, double radius, int way, int turns) {
    static_cast<void>(job.begin(speed, radius, 0.0));
    for (int i = 0; i < turns; ++i) {
        job.arc(0.0, way * radius, -radius, 0.0);
        job.arc(0.0, -way * radius, radius, 0.0);
    }
    job.end();
}

void line(PulseJob& job, double speed, double x, double z) {
    static_cast<void>(job.begin(speed, -x, -z, kExactNm));
    job.line(x, z);
    job.end();
}

/// Two straights and two turns so tight that the mirrors must slow down for them and speed up again.
void slot(PulseJob& job, double x, double radius, int way) {
    static_cast<void>(job.begin(2.0, -x, -way * radius));
    job.line(x, -way * radius);
    job.arc(x + radius, 0.0, x, way * radius);
    job.line(-x, way * radius);
    job.arc(-x - radius, 0.0, -x, -way * radius);
    job.end();
}

/// Right angles, `leg` apart: the speed goes from rest to what the leg allows and back. No corner lies at a whole
/// number of pitches: there would be no light there, at rest.
void stairs(PulseJob& job, double leg, int steps, int way) {
    const double half = 0.5 * leg * steps;
    static_cast<void>(job.begin(2.0, -half, -way * half, kExactNm));
    for (int i = 0; i < steps; ++i) {
        job.line(-half + leg * (i + 1), way * (-half + leg * i));
        job.line(-half + leg * (i + 1), way * (-half + leg * (i + 1)));
    }
    job.end();
}

}  // namespace

PulseWorkload pulse_workload() {
    PulseJob job(50'000, 1'800'000);
    for (const int way : {1, -1}) {
        circle(job, 2.0, 20.0, way, 1);
        circle(job, 2.0, 5.0, way, 2);
        circle(job, 2.0, 1.0, way, 4);
        slot(job, 6.0, 0.4, way);
        for (const double speed : {0.1, 0.2, 0.5, 1.0, 2.0}) {
            const double half = way * (speed < 0.3 ? 4.0 : 20.0);
            line(job, speed, half, 0.0);
            line(job, speed, 0.0, half);
            line(job, speed, half, 0.4 * half);
        }
    }
    PulseWorkload made;
    for (const int way : {1, -1}) {
        stairs(job, 3.0137, 8, way);
        stairs(job, 0.6137, 20, way);
    }
    made.items = job.items();
    for (const Item& item : made.items) {
        const auto* begin = std::get_if<PathBegin>(&item);
        if (begin != nullptr && begin->tolerance_nm == kExactNm) {
            made.straight.push_back(begin->path);
        }
    }
    return made;
}

namespace {

/// One path of lines to and fro, so long that its last pulse is the millionth.
std::vector<Item> drift_workload() {
    constexpr double kHalf = 50.001585;
    constexpr double kStep = 0.50271;
    constexpr int kLines = 100;
    static_assert(kLines * 2 * kHalf * 1e5 >= kDriftPulses * 10);
    PulseJob job(10'000, 300'000);
    static_cast<void>(job.begin(2.0, -kHalf, -0.5 * kStep * kLines, kExactNm));
    for (int i = 0; i < kLines; ++i) {
        const double z = kStep * (i - 0.5 * kLines);
        const double end = i % 2 == 0 ? kHalf : -kHalf;
        job.line(end, z);
        job.line(end, z + kStep);
    }
    job.end();
    return job.items();
}

std::string row(const char* name, const PulseFigures& f) {
    return fmt::format("{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{}\n", name, f.pulses, f.lost,
                       f.pitch_rms * 100.0, f.pitch_peak * 100.0, f.placement_rms * 1e6, f.placement_peak * 1e6,
                       f.energy_peak * 100.0, f.energy_per_length_peak * 100.0, f.drift);
}

}  // namespace

std::filesystem::path beam_world(const std::string& name) {
    const auto root = find_project_root();
    if (!root) {
        throw CellError("the bench's world is not beside this program: set SCRIBECELL_ROOT to the project's folder");
    }
    return *root / "boards/sim/world/beam" / name;
}

GalvoField nominal_field() {
    GalvoModel nominal;
    nominal.value[GalvoModel::kF1] = nominal.angle_scale;
    nominal.value[GalvoModel::kExitX] = nominal.value[GalvoModel::kExitZ] = 1.0 / nominal.angle_scale;
    return nominal.field();
}

std::vector<trace::PulseRecord> burn_pulses(const std::vector<Item>& items, const PulseCell& cell,
                                            const std::filesystem::path& folder) {
    LinkOptions link;
    link.world = cell.world;
    link.seed = cell.seed;
    link.out = folder;
    link.prr_nominal_hz = cell.prr_hz;
    link.machine = {"galvo.word=18"};
    link.machine.insert(link.machine.end(), cell.machine.begin(), cell.machine.end());
    {
        const auto transport = open_transport("sim:", link);
        CellClient client(*transport, {.session = static_cast<std::uint32_t>(cell.seed) + 1U});
        client.set_stop_check(stop_requested);
        client.connect();
        Session session(client, {});
        session.clear();
        client.set_galvo_field(nominal_field());
        client.set_galvo_lag(cell.lag);
        static_cast<void>(session.run({job_hash(items), items, 60.0}, nullptr));
    }
    return read_pulse_trace(folder / "pulses.trace").pulses;
}

std::vector<Figure> bench_pulses(const BenchOptions& options) {
    const RunFolder folder(options.raw);
    const PulseWorkload work = pulse_workload();
    const std::vector<DrawnJobPath> job = draw(work.items);
    std::string table =
        "run,pulses,lost,pitch_rms_pct,pitch_peak_pct,placement_rms_um,placement_peak_um,energy_peak_pct,"
        "energy_per_mm_peak_pct,drift_pulses\n";
    struct Judged {
        PulseFigures all;
        PulseFigures straight;
    };
    const auto run = [&](const char* name, const char* world, const std::vector<std::string>& machine) {
        const auto pulses = burn_pulses(
            work.items, {.world = beam_world(world), .machine = machine, .seed = options.seed}, folder.path() / name);
        // Where the axes stand is known from the paths whose pulses have places of their own.
        const PulseFigures straight = check_pulses(job, pulses, {.only = work.straight});
        const Judged judged{check_pulses(job, pulses, {.stand = straight.stand}), straight};
        table += row(name, judged.all) + row((std::string(name) + "_straight").c_str(), judged.straight);
        return judged;
    };
    const std::vector<std::string> no_servo{"galvo.natural_frequency_hz=0"};
    const std::vector<std::string> no_lag{"galvo.natural_frequency_hz=0", "galvo.latency_us=0"};
    const Judged exact = run("exact", "world.toml", {});
    const Judged time_only = run("time_only", "world.toml", no_servo);
    const Judged without_lag = run("without_lag", "world.toml", no_lag);
    const Judged without_law = run("without_law", "world.toml", {"laser.power_byte=energy"});
    const Judged slow = run("slow_laser", "slow_laser.toml", {});
    const std::vector<Item> circles = drift_workload();
    const PulseFigures drift = check_pulses(
        draw(circles),
        burn_pulses(circles, {.world = beam_world("world.toml"), .prr_hz = kDriftPrrHz, .seed = options.seed},
                    folder.path() / "drift"));
    table += row("drift", drift);
    if (options.raw) {
        write_text_file(folder.path() / "pulses.csv", table);
    }
    return {{"pitch_error_rms_pct", exact.all.pitch_rms * 100.0, "%"},
            {"pitch_error_peak_pct", exact.all.pitch_peak * 100.0, "%"},
            {"pitch_drift_pulses", drift.drift, ""},
            {"pitch_drift_of_pulses", static_cast<double>(drift.pulses), ""},
            {"pulses_lost", static_cast<double>(exact.straight.lost + drift.lost), ""},
            {"placement_rms_um", exact.straight.placement_rms * 1e6, "um"},
            {"placement_peak_um", exact.straight.placement_peak * 1e6, "um"},
            {"energy_error_pct", exact.all.energy_peak * 100.0, "%"},
            {"energy_per_mm_error_pct", exact.all.energy_per_length_peak * 100.0, "%"},
            {"energy_slow_laser_pct", slow.all.energy_peak * 100.0, "%"},
            {"energy_per_mm_slow_laser_pct", slow.all.energy_per_length_peak * 100.0, "%"},
            {"pitch_without_lag_peak_pct", without_lag.all.pitch_peak * 100.0, "%"},
            {"placement_without_lag_peak_um", without_lag.straight.placement_peak * 1e6, "um"},
            {"placement_time_only_peak_um", time_only.straight.placement_peak * 1e6, "um"},
            {"energy_without_law_pct", without_law.all.energy_peak * 100.0, "%"}};
}

}  // namespace sc::host::cli
