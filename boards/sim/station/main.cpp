// SPDX-License-Identifier: Apache-2.0
// scribecell-station: a triple-laser head with true errors, its calibration stand, and stations along a rail, as files.
#include <cstdio>
#include <exception>
#include <numbers>
#include <string>

#include <CLI/CLI.hpp>

#include "boards/sim/station/data_set.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr const char* kExamples = R"(Examples:
  scribecell-station head --out data --seed 3
      a head that a workshop made: pictures and readings of its calibration stand, stations at known angles, stations
      at 60 to 90 degrees, and the truth
  scribecell-station head --out data --repeats 100 --no-pictures
      more stations, nothing to see
  scribecell-station spots --out spots --count 400
      pictures of laser spots with tilt, saturation, speckle and background, and where they truly are

Exit codes: 0 done; 1 a file cannot be written; 2 bad usage.)";

struct Words {
    sc::sim::DataSetOptions set;
    std::string out;
    double side_mm = 100.0;
    double sigma_mm = 0.1;
    double seat_deg = 0.0;
    double seat_mm = 0.0;
    bool no_pictures = false;
    int count = 400;
};

void add_head(CLI::App& app, Words& words) {
    CLI::App* sub = app.add_subcommand("head", "One head: stand, known stations, stations, truth.");
    sub->add_option("--out", words.out, "folder to write to")->required()->type_name("DIR");
    sub->add_option("--seed", words.set.seed, "of all that is random")->capture_default_str();
    sub->add_option("--side-mm", words.side_mm, "of the triangle")
        ->check(CLI::Range(1.0, 1000.0))
        ->capture_default_str();
    sub->add_option("--sigma-mm", words.sigma_mm, "noise of a reading")
        ->check(CLI::Range(0.0, 10.0))
        ->capture_default_str();
    sub->add_option("--readings", words.set.readings, "a station")->check(CLI::Range(1, 10000))->capture_default_str();
    sub->add_option("--repeats", words.set.repeats, "stations at each angle")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    sub->add_option("--angles-deg", words.set.angles_deg, "angles of the stations")
        ->delimiter(',')
        ->check(CLI::Range(40.0, 140.0));
    sub->add_option("--seat-deg", words.seat_deg, "how the base sits when it is put down again, 1 sigma")
        ->check(CLI::Range(0.0, 5.0))
        ->capture_default_str();
    sub->add_option("--seat-mm", words.seat_mm, "the same as a place")
        ->check(CLI::Range(0.0, 10.0))
        ->capture_default_str();
    sub->add_flag("--no-pictures", words.no_pictures, "leave the pictures out");
    sub->callback([&words] {
        words.set.side = words.side_mm * 1e-3;
        words.set.sigma = words.sigma_mm * 1e-3;
        words.set.seat_angle = words.seat_deg * kDegree;
        words.set.seat_place = words.seat_mm * 1e-3;
        words.set.pictures = !words.no_pictures;
        sc::sim::write_data_set(words.out, words.set);
    });
}

}  // namespace

int main(int argc, char** argv) {
    try {
        CLI::App app{"A simulated triple-laser head, its stand and its stations, as files.", "scribecell-station"};
        app.footer(kExamples);
        app.require_subcommand(1);
        Words words;
        add_head(app, words);
        CLI::App* spots = app.add_subcommand("spots", "Pictures of laser spots.");
        spots->add_option("--out", words.out, "folder to write to")->required()->type_name("DIR");
        spots->add_option("--count", words.count, "pictures")->check(CLI::Range(1, 100000))->capture_default_str();
        spots->add_option("--seed", words.set.seed, "of all that is random")->capture_default_str();
        spots->callback([&words] { sc::sim::write_spots(words.out, words.count, words.set.seed); });
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-station: %s\n", error.what());
        return kFailed;
    }
}
