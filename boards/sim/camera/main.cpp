// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <fstream>
#include <string>

#include <CLI/CLI.hpp>

#include "boards/sim/camera/plate_camera.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr const char* kExamples = R"(Examples:
  scribecell-plate-camera run1/pulses.trace --out measured.csv
      measures the crosses that a simulated cell has burnt, with a noise of 7.5 um (1 sigma) in x and z
  scribecell-plate-camera run1/pulses.trace --sigma-um 0 --out exact.csv
      without noise
  scribecell-plate-camera run2/pulses.trace --marks --out marks.csv
      each mark of each line

Exit codes: 0 done; 1 the crosses cannot be told; 2 bad usage.)";

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Measures the crosses or lines on a plate that the simulated cell has burnt.",
                 "scribecell-plate-camera"};
    std::string trace;
    std::string out;
    double sigma_um = 7.5;
    std::uint64_t seed = 1;
    bool marks = false;
    try {
        app.footer(kExamples);
        app.add_option("trace", trace, "pulse trace of the run")->required()->type_name("FILE");
        app.add_option("--out", out, "CSV to write")->required()->type_name("FILE");
        app.add_option("--sigma-um", sigma_um, "noise of x and of z")
            ->check(CLI::Range(0.0, 1000.0))
            ->capture_default_str();
        app.add_flag("--marks", marks, "every mark of every line, not the crosses that lines make");
        app.add_option("--seed", seed, "of the noise")->capture_default_str();
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        const auto pulses = sc::sim::read_pulses(trace);
        const std::string text =
            marks ? sc::sim::marks_csv(sc::sim::find_plate_marks(pulses), sigma_um * 1e-6, seed)
                  : sc::sim::measured_csv(sc::sim::find_plate_crosses(pulses), sigma_um * 1e-6, seed);
        std::ofstream file(out);
        file << text;
        file.close();
        if (!file) {
            std::fprintf(stderr, "scribecell-plate-camera: %s cannot be written\n", out.c_str());
            return kFailed;
        }
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-plate-camera: %s\n", error.what());
        return kFailed;
    }
}
