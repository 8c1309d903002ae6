// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "boards/bench/bus/bus_load.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr const char* kExamples = R"(Examples:
  scribecell-bus-bench
      the share of the drive bus as computed, beside frames counted on it, for 3, 4 and 6 axes, as one JSON object
  scribecell-bus-bench --seconds 20

Exit codes: 0 done; 1 failed; 2 bad usage.)";

nlohmann::ordered_json object_of(const sc::bench::BusResult& result) {
    const sc::bench::FrameCounts& frames = result.frames;
    return {{"name", result.of.name},
            {"axes", result.of.axes},
            {"by_master", result.by_master},
            {"cyclic_pct", 100.0 * result.cyclic},
            {"computed_pct", 100.0 * result.computed},
            {"counted_pct", 100.0 * result.counted},
            {"wire_pct", 100.0 * result.wire},
            {"with_reserve_pct", 100.0 * result.total},
            {"error_pct", result.error_pct()},
            {"carried", result.carried},
            {"seconds", result.seconds},
            {"frames",
             {{"sync", frames.sync},
              {"targets", frames.targets},
              {"status", frames.status},
              {"heartbeats", frames.heartbeats},
              {"other", frames.other}}}};
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"What drives take of their bus: computed, and counted on it.", "scribecell-bus-bench"};
    double seconds = 2.0;
    std::uint32_t seed = 1;
    try {
        app.footer(kExamples);
        app.add_option("--seconds", seconds, "of steady running, each case")
            ->check(CLI::Range(0.1, 600.0))
            ->capture_default_str();
        app.add_option("--seed", seed, "of the search for long frames")->capture_default_str();
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        constexpr int kRounds = 300;
        nlohmann::ordered_json object{{"cases", nlohmann::json::array()}, {"stuffing", nlohmann::json::array()}};
        for (const sc::bench::BusCase& which : sc::bench::bus_cases()) {
            const sc::bench::BusResult by_nodes = sc::bench::measure_bus(which, false, seconds);
            object["cases"].push_back(object_of(by_nodes));
            if (which.axes == 4 && by_nodes.total <= 1.0) {
                object["cases"].push_back(object_of(sc::bench::measure_bus(which, true, seconds)));
            }
        }
        for (const sc::bench::StuffingResult& found : sc::bench::search_stuffing(seed, kRounds)) {
            object["stuffing"].push_back({{"bytes", found.bytes}, {"bound", found.bound}, {"found", found.found}});
        }
        std::printf("%s\n", object.dump(2).c_str());
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-bus-bench: %s\n", error.what());
        return kFailed;
    }
}
