// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "boards/bench/sensors/bus_share.hpp"
#include "boards/sim/world/world_error.hpp"
#include "shared/machine/machine.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr const char* kExamples = R"(Examples:
  scribecell-sensor-bench --world boards/sim/world/default/world.toml
      readings a second on both sensor buses beside what the lines can carry, as one JSON object
  scribecell-sensor-bench --world my_world.toml --seconds 600

Exit codes: 0 done; 1 failed; 2 bad input or usage.)";

nlohmann::ordered_json object_of(const sc::bench::BusShare& share) {
    return {{"share", share.share()},
            {"readings_per_s", share.readings_per_s},
            {"new_per_s", share.new_per_s},
            {"limit_per_s", share.limit_per_s}};
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"How near the sensor buses come to what their lines can carry.", "scribecell-sensor-bench"};
    std::string world;
    double seconds = 60.0;
    try {
        app.footer(kExamples);
        app.add_option("--world", world, "world file")->required()->type_name("FILE");
        app.add_option("--seconds", seconds, "of the cell's time")
            ->check(CLI::Range(1.0, 3600.0))
            ->capture_default_str();
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        const sc::SensorsConfig config = sc::reference_machine().sensors;
        const sc::sim::World cell{std::filesystem::path(world)};
        const auto shares = sc::bench::measure_bus_shares(cell, config, seconds, false);
        const auto late = sc::bench::measure_bus_shares(cell, config, seconds, true);
        const nlohmann::ordered_json object{{"y", object_of(shares.y)},
                                            {"triple", object_of(shares.triple)},
                                            {"y_late", object_of(late.y)},
                                            {"triple_late", object_of(late.triple)}};
        std::printf("%s\n", object.dump(2).c_str());
        return 0;
    } catch (const sc::sim::WorldError& error) {
        std::fprintf(stderr, "scribecell-sensor-bench: %s\n", error.what());
        return kBadInput;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-sensor-bench: %s\n", error.what());
        return kFailed;
    }
}
