// SPDX-License-Identifier: Apache-2.0
#include "host/cli/bench_pendant.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/program.hpp"
#include "host/bridge/session.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/pendant_run.hpp"
#include "host/cli/run_folder.hpp"
#include "host/formats/file.hpp"
#include "host/pendant/script_port.hpp"
#include "host/verification/motion_trace.hpp"

namespace sc::host::cli {
namespace {

constexpr double kFirstMs = 200.0;
constexpr double kApartMs = 400.37;  ///< a jog of 1 mm is over by then; and each finds another phase of the drive cycle
constexpr int kEach = 3;             ///< detents a way, for each axis and step

/// Detents of every axis and step, there and back.
std::vector<pendant::ScriptPort::Event> detents() {
    std::string text = "0 plug\n0 axis off\n";
    double at = kFirstMs;
    for (const char* axis : {"x", "y", "z"}) {
        text += fmt::format("{:.3f} axis {}\n", at, axis);
        for (const char* feed : {"0.001", "60%", "0.01", "0.1", "1"}) {
            text += fmt::format("{:.3f} feed {}\n", at, feed);
            for (int i = 0; i < 2 * kEach; ++i) {
                at += kApartMs;
                text += fmt::format("{:.3f} wheel {}\n", at, i % 2 == 0 ? -1 : 1);
            }
        }
        at += kApartMs;
    }
    return pendant::parse_script(text, "detents");
}

struct Measured {
    std::vector<PendantJog> jogs;
    MotionTrace trace;
    std::size_t asked = 0;
};

Measured measure(const std::string& url, const BenchOptions& options, const std::filesystem::path& folder) {
    LinkOptions link;
    link.seed = options.seed;
    link.out = folder;
    const auto events = detents();
    Measured out;
    for (const auto& event : events) {
        const auto report = pendant::parse_report(std::span(event.event.bytes).first(event.event.size));
        out.asked += report && report->detents != 0 ? 1U : 0U;
    }
    {
        const auto transport = open_transport(url, link);
        CellClient client(*transport, {.session = static_cast<std::uint32_t>(options.seed) + 1U});
        client.set_stop_check(stop_requested);
        client.connect();
        Session session(client, {});
        session.clear();
        session.enable_and_home();
        pendant::ScriptPort port(events);
        PendantRun run(client, port, {});
        run.run();
        session.make_safe();
        out.jogs = run.jogs();
    }
    out.trace = read_motion_trace(folder / "samples.trace");
    return out;
}

/// Drive cycles from a look before the detent was taken to when the first set-point that moves acts; nothing if none
/// moved within a second.
std::optional<double> cycles_of(const PendantJog& jog, const MotionTrace& trace) {
    constexpr std::int64_t kLongest = 1000;
    const double period_ns = trace.period * 1e9;
    const auto first =
        static_cast<std::int64_t>(std::floor(static_cast<double>(jog.asked.time_since_epoch().count()) / period_ns)) -
        trace.first_tick;
    const std::size_t axis = index(jog.axis);
    for (std::int64_t i = std::max<std::int64_t>(first, 1);
         i < std::min<std::int64_t>(first + kLongest, std::ssize(trace.samples)); ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (trace.samples[at][axis] != trace.samples[at - 1][axis]) {
            const double acts_ns = static_cast<double>(i + trace.first_tick + 1) * period_ns;
            const double asked_ns =
                static_cast<double>((jog.asked - PendantRunOptions().look).time_since_epoch().count());
            const double cycle_ns = period_ns * reference_machine().drive_cycle_ticks;
            return (acts_ns - asked_ns) / cycle_ns;
        }
    }
    return std::nullopt;
}

}  // namespace

std::vector<Figure> detent_figures(const BenchOptions& options) {
    const RunFolder folder(options.raw);
    std::vector<Figure> figures;
    std::string table = "link,axis,distance_um,asked_ms,cycles\n";
    for (const auto& [name, url] : {std::pair{"detent_cycles", "sim:"}, {"detent_cycles_can", "sim:?carrier=can"}}) {
        std::fprintf(stderr, "turning a pendant's wheel: %s\n", url);
        const Measured measured = measure(url, options, folder.path() / name);
        if (measured.jogs.size() != measured.asked) {
            throw CellError(fmt::format("of {} detents {} became a jog", measured.asked, measured.jogs.size()));
        }
        double worst = 0.0;
        for (const PendantJog& jog : measured.jogs) {
            const auto cycles = cycles_of(jog, measured.trace);
            if (!cycles) {
                throw CellError("a detent has moved nothing");
            }
            worst = std::max(worst, *cycles);
            table += fmt::format("{},{},{:.3f},{:.6f},{:.4f}\n", url, "XYZC"[index(jog.axis)], 1e6 * jog.distance,
                                 1e-6 * static_cast<double>(jog.asked.time_since_epoch().count()), *cycles);
        }
        figures.push_back({name, worst, "cycles"});
    }
    if (options.raw) {
        write_text_file(folder.path() / "detents.csv", table);
    }
    return figures;
}

std::vector<Figure> guest_figures(const BenchOptions& options) {
    const auto root = find_project_root();
    const auto program = find_program("scribecell");
    if (!root || !program) {
        throw CellError("tests/guest is not beside this program; set SCRIBECELL_ROOT to the project's folder");
    }
    const RunFolder folder(options.raw);
    const std::filesystem::path file = folder.path() / "guest.json";
    std::fprintf(stderr, "cases against a Linux kernel in QEMU; some minutes\n");
    const ProgramOutput done =
        run_program("/usr/bin/python3", {"-B", (*root / "tests/guest/guest.py").string(),
                                         program->parent_path().parent_path().string(), "--json", file.string()});
    std::fputs(done.text.c_str(), stderr);
    if (done.exit_code != 0 && done.exit_code != 1) {
        std::fprintf(stderr, "guest_cases is left out\n");
        return {};
    }
    const nlohmann::json found = nlohmann::json::parse(read_text_file(file));
    const double tried = found.at("tried").get<double>();
    const double passed = found.at("passed").get<double>();
    return {{"guest_cases", passed, fmt::format("of {:g}", tried)}, {"guest_cases_failed", tried - passed, ""}};
}

}  // namespace sc::host::cli
