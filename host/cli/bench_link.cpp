// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/bench_figures.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/file.hpp"
#include "host/formats/pulse_trace.hpp"

namespace sc::host::cli {
namespace {

namespace fs = std::filesystem;
using Pulses = std::vector<trace::PulseRecord>;

constexpr const char* kBenchProgram = "scribecell-link-bench";
constexpr int kKills = 200;
constexpr int kPowerCuts = 20;

/// What befalls one run.
struct Trial {
    double kill_host_s = 0.0;
    int kill_delay_us = 0;
    double power_off_s = 0.0;
    double gap_s = 0.0;
};

/// A simulated cell that outlives its hosts.
class LastingCellProcess {
public:
    LastingCellProcess(const fs::path& folder, const std::string& out, const Trial& trial, int start)
        : socket_(folder / "socket"),
          trace_(folder / out / "pulses.trace"),
          cell_(required_program("scribecell-cell"),
                {"--lockstep", socket_.string(), "--out", (folder / out).string(), "--memory",
                 (folder / "retained.bin").string(), "--world", (folder.parent_path() / "world.toml").string(),
                 "--seed", std::to_string(start), "--kill-host-at", fmt::format("{:.6f}", trial.kill_host_s),
                 "--kill-delay-us", std::to_string(trial.kill_delay_us), "--power-off-at",
                 fmt::format("{:.6f}", trial.power_off_s), "--gap", fmt::format("{:.3f}", trial.gap_s)}) {
        constexpr int kLooks = 2000;
        for (int i = 0; i < kLooks && !fs::exists(socket_); ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
    }
    /// The socket may lie in a folder whose name is long.
    [[nodiscard]] std::string url() const { return "lockstep:" + socket_.string(); }
    [[nodiscard]] Pulses end() {
        ::kill(cell_.id(), SIGTERM);
        if (cell_.finish() != 0) {
            throw CellError("the simulated cell ended with an error (its message stands above)");
        }
        return read_pulse_trace(trace_).pulses;
    }

private:
    fs::path socket_;
    fs::path trace_;
    ChildProcess cell_;
};

int scribe(const LastingCellProcess& cell, const fs::path& folder, const std::vector<std::string>& more) {
    std::vector<std::string> words{
        "scribe", "--face", "0", "--link", cell.url(), "--journal", (folder / "journal.sqlite").string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(required_program("scribecell"), words, ProgramErrors::dropped).exit_code;
}

/// How a run's pulses differ from the undisturbed run's, one by one.
struct Difference {
    std::int64_t missing = 0;
    std::int64_t doubled = 0;
    double place_um = 0.0;  ///< worst pulse, on the part
    double seam_um = 0.0;   ///< worst distance between neighbours
    double energy_pct = 0.0;
};

double distance_um(const trace::PulseRecord& a, const trace::PulseRecord& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto d = static_cast<double>(a.table_pm[i] - b.table_pm[i]) * 1e-6;
        sum += d * d;
    }
    return std::sqrt(sum);
}

/// `gap`: so many pulses are missing behind the first `before`.
Difference compare(const Pulses& pulses, const Pulses& truth, std::size_t before, std::int64_t gap) {
    Difference d;
    d.missing = std::max<std::int64_t>(gap, 0);
    d.doubled = std::max<std::int64_t>(-gap, 0);
    for (std::size_t i = 0; i < pulses.size(); ++i) {
        const std::int64_t at = static_cast<std::int64_t>(i) + (i < before ? 0 : gap);
        if (at < 0 || at >= static_cast<std::int64_t>(truth.size())) {
            ++d.doubled;
            continue;
        }
        const trace::PulseRecord& t = truth[static_cast<std::size_t>(at)];
        d.place_um = std::max(d.place_um, distance_um(pulses[i], t));
        if (i > 0 && i != before && at > 0) {
            const double here = distance_um(pulses[i], pulses[i - 1]);
            const double there = distance_um(t, truth[static_cast<std::size_t>(at) - 1]);
            d.seam_um = std::max(d.seam_um, std::abs(here - there));
        }
        const double energy = static_cast<double>(pulses[i].energy_nj) / static_cast<double>(t.energy_nj) - 1.0;
        d.energy_pct = std::max(d.energy_pct, 100.0 * std::abs(energy));
    }
    return d;
}

class ResumeBench {
public:
    ResumeBench(const BenchOptions& options) : folder_(options.raw), random_(options.seed) {
        write_world(*find_project_root() / "boards/sim/world/default");
        const fs::path place = fresh("undisturbed");
        LastingCellProcess cell(place, "cell", {}, 1);
        if (scribe(cell, place, {}) != 0) {
            throw CellError("the undisturbed run failed: try `scribecell scribe --face 0`");
        }
        truth_ = cell.end();
        seconds_ = static_cast<double>(truth_.back().t_ns) * 1e-9;
        table_.open(folder_.path() / "resume.csv");
        table_ << "trial,kill_s,gap_s,power_off_s,first_exit,last_exit,pulses,missing,doubled,place_um,seam_um,energy_"
                  "pct\n";
    }

    void add_to(std::vector<Figure>& figures) {
        Difference worst;
        int failed = 0;
        for (int i = 0; i < kKills; ++i) {
            // One in five is away for longer than the cell waits: its fault is acknowledged, and the job begun anew.
            const bool long_away = i % 5 == 4;
            const Trial trial{.kill_host_s = even(0.05, seconds_ + 0.3),
                              .kill_delay_us = static_cast<int>(even(0.0, 2000.0)),
                              .gap_s = long_away ? even(10.5, 12.0) : even(0.05, 8.0)};
            failed += run_killed(i, trial, worst) ? 0 : 1;
        }
        figures.push_back({"kill_runs", kKills, ""});
        figures.push_back({"kill_runs_failed", static_cast<double>(failed), ""});
        figures.push_back({"kill_pulses_missing", static_cast<double>(worst.missing), ""});
        figures.push_back({"kill_pulses_doubled", static_cast<double>(worst.doubled), ""});
        figures.push_back({"kill_place_um", worst.place_um, "um"});
        figures.push_back({"kill_seam_um", worst.seam_um, "um"});
        figures.push_back({"kill_energy_pct", worst.energy_pct, "%"});
        Difference cut;
        int cut_failed = 0;
        for (int i = 0; i < kPowerCuts; ++i) {
            const double lit = static_cast<double>(truth_.front().t_ns) * 1e-9;
            const Trial trial{.power_off_s = even(lit, seconds_)};
            cut_failed += run_cut(i, trial, cut) ? 0 : 1;
        }
        figures.push_back({"power_cuts", kPowerCuts, ""});
        figures.push_back({"power_cuts_failed", static_cast<double>(cut_failed), ""});
        figures.push_back({"power_pulses_doubled", static_cast<double>(cut.doubled), ""});
        figures.push_back({"power_pulses_missing", static_cast<double>(cut.missing), ""});
    }

private:
    double even(double low, double high) {
        const double share = static_cast<double>(random_() >> 11U) * 0x1p-53;
        return low + share * (high - low);
    }
    /// The first pulses after the dark are stronger in the reference cell: that is the source's, not the job's.
    void write_world(const fs::path& reference) const {
        const std::string key = "first_pulse_excess = 0.12";
        std::string text = read_text_file(reference / "world.toml");
        const std::size_t at = text.find(key);
        if (at == std::string::npos) {
            throw CellError("the reference cell's world has no line '" + key + "': this benchmark must follow it");
        }
        text.replace(at, key.size(), "first_pulse_excess = 0.0");
        write_text_file(folder_.path() / "world.toml", text);
        fs::copy_file(reference / "workpiece.obj", folder_.path() / "workpiece.obj",
                      fs::copy_options::overwrite_existing);
    }
    fs::path fresh(const std::string& name) {
        if (stop_requested()) {
            throw Interrupted();
        }
        const fs::path place = folder_.path() / name;
        fs::remove_all(place);
        fs::create_directories(place);
        return place;
    }
    void note(int number, const Trial& trial, int first, int last, std::size_t pulses, const Difference& d,
              Difference& worst) {
        table_ << fmt::format("{},{:.3f},{:.3f},{:.3f},{},{},{},{},{},{:.3f},{:.3f},{:.3f}\n", number,
                              trial.kill_host_s, trial.gap_s, trial.power_off_s, first, last, pulses, d.missing,
                              d.doubled, d.place_um, d.seam_um, d.energy_pct);
        table_.flush();
        worst.missing = std::max(worst.missing, d.missing);
        worst.doubled = std::max(worst.doubled, d.doubled);
        worst.place_um = std::max(worst.place_um, d.place_um);
        worst.seam_um = std::max(worst.seam_um, d.seam_um);
        worst.energy_pct = std::max(worst.energy_pct, d.energy_pct);
    }

    /// The host is killed, and started again with --resume.
    bool run_killed(int number, const Trial& trial, Difference& worst) {
        std::fprintf(stderr, "host killed at %.3f s, %d of %d\n", trial.kill_host_s, number + 1, kKills);
        const fs::path place = fresh("killed");
        LastingCellProcess cell(place, "cell", trial, 1);
        const int first = scribe(cell, place, {});
        constexpr int kKilled = 128 + SIGKILL;
        const bool journal = fs::exists(place / "journal.sqlite");
        int last = first;
        if (first == kKilled) {
            // Killed before it wrote a journal, it has sent nothing.
            last = scribe(cell, place,
                          journal ? std::vector<std::string>{"--resume", "--reset-fault"}
                                  : std::vector<std::string>{"--reset-fault"});
        }
        const Pulses pulses = cell.end();
        const auto gap = static_cast<std::int64_t>(truth_.size()) - static_cast<std::int64_t>(pulses.size());
        note(number, trial, first, last, pulses.size(), compare(pulses, truth_, pulses.size(), gap), worst);
        return last == 0;
    }

    /// The cell loses its power, and so does the host's session; a person takes what is uncertain for burnt.
    bool run_cut(int number, const Trial& trial, Difference& worst) {
        std::fprintf(stderr, "power lost at %.3f s, %d of %d\n", trial.power_off_s, number + 1, kPowerCuts);
        const fs::path place = fresh("cut");
        LastingCellProcess dark(place, "before", trial, 1);
        const int first = scribe(dark, place, {});
        Pulses pulses = dark.end();
        const std::size_t before = pulses.size();
        LastingCellProcess cell(place, "after", {}, 2);
        const int last = scribe(cell, place, {"--resume", "--confirm-uncertain", "burnt"});
        const Pulses rest = cell.end();
        pulses.insert(pulses.end(), rest.begin(), rest.end());
        const auto gap = static_cast<std::int64_t>(truth_.size()) - static_cast<std::int64_t>(pulses.size());
        Difference d = compare(pulses, truth_, before, gap);
        // The axes have been homed anew: places are judged where they were not.
        d.seam_um = d.place_um = 0.0;
        note(number, trial, first, last, pulses.size(), d, worst);
        return first != 0 && last == 0;
    }

    RunFolder folder_;
    std::mt19937_64 random_;
    Pulses truth_;
    double seconds_ = 0.0;
    std::ofstream table_;
};

}  // namespace

std::vector<Figure> bench_link(const BenchOptions& options) {
    const auto root = find_project_root();
    if (!root) {
        throw CellError("the workload is not beside this program: set SCRIBECELL_ROOT to the project's folder");
    }
    const fs::path dense = *root / "tests/data/motion/a_dense.csv";
    const ProgramOutput output =
        run_program(required_program(kBenchProgram), {dense.string(), "1", std::to_string(options.seed)});
    const auto object = nlohmann::json::parse(output.text, nullptr, false);
    if (output.exit_code != 0 || !object.is_object()) {
        throw CellError(std::string(kBenchProgram) + " ended with " + std::to_string(output.exit_code));
    }
    std::vector<Figure> figures;
    for (const auto& [name, value] : object.items()) {
        const bool rate = name.ends_with("_points_per_s") || name.ends_with("_limit");
        figures.push_back({name, value.get<double>(), rate ? "1/s" : name == "resume_s" ? "s" : ""});
    }
    ResumeBench(options).add_to(figures);
    return figures;
}

}  // namespace sc::host::cli
