// SPDX-License-Identifier: Apache-2.0
// scribecell-circles: pictures of circular markers with exact perspective, and where the markers truly are.
#include <cstdio>
#include <exception>
#include <string>

#include <CLI/CLI.hpp>

#include "boards/sim/circles/circle_sets.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr const char* kExamples = R"(Examples:
  scribecell-circles singles --out singles --scenes 24 --repeats 50
      one tilted marker a picture, at places of its own within a pixel
  scribecell-circles boards --out boards --scenes 6 --repeats 20 --seed 3
      five markers on a plane tilted by 45 degrees
  scribecell-circles pairs --out pairs --scenes 3 --repeats 1
      a target of 20 markers before a pair of cameras, some covered, some strangers

Written are pictures, camera.csv, and truth.csv with the middle of each ellipse and of each circle.
Exit codes: 0 done; 1 a file cannot be written; 2 bad usage.)";

}  // namespace

int main(int argc, char** argv) {
    try {
        CLI::App app{"Pictures of circular markers, and where they truly are.", "scribecell-circles"};
        app.footer(kExamples);
        app.require_subcommand(1);
        std::string out;
        sc::sim::SetOptions options;
        const auto add = [&](const char* name, const char* what, auto write) {
            CLI::App* sub = app.add_subcommand(name, what);
            sub->add_option("--out", out, "folder to write to")->required()->type_name("DIR");
            sub->add_option("--scenes", options.scenes, "places and tilts")
                ->check(CLI::Range(1, 1000))
                ->capture_default_str();
            sub->add_option("--repeats", options.repeats, "pictures of each")
                ->check(CLI::Range(1, 1000))
                ->capture_default_str();
            sub->add_option("--seed", options.seed, "of all that is random")->capture_default_str();
            sub->callback([&out, &options, write] { write(out, options); });
        };
        add("singles", "One marker a picture.", sc::sim::write_singles);
        add("boards", "Five markers on a plane.", sc::sim::write_boards);
        add("pairs", "A target before a pair of cameras.", sc::sim::write_pairs);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-circles: %s\n", error.what());
        return kFailed;
    }
}
