// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "boards/bench/field/field_truth.hpp"
#include "boards/sim/world/world_error.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr const char* kExamples = R"(Examples:
  scribecell-field-truth numbers.txt --world boards/sim/world/plate/world.toml
      what a field correction (its numbers, one a line) leaves over in that world, as one JSON object
  scribecell-field-truth numbers.txt --world my_world.toml --no-depth
      the same with the controller told that every place is in focus

Exit codes: 0 done; 1 failed; 2 bad input or usage.)";

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Compares a galvo field correction with the true head of a world.", "scribecell-field-truth"};
    std::string numbers;
    std::string world;
    double half_mm = 55.0;
    double depth_mm = 1.0;
    int bits = 16;
    bool no_depth = false;
    std::vector<double> anchor{0.0, 0.0, 0.0};
    std::vector<double> reading{0.0, 0.0, 0.0};
    try {
        app.footer(kExamples);
        app.add_option("numbers", numbers, "the correction's numbers")->required()->type_name("FILE");
        app.add_option("--world", world, "world file")->required()->type_name("FILE");
        app.add_option("--half-mm", half_mm, "half the edge of the field")
            ->check(CLI::Range(0.1, 60.0))
            ->capture_default_str();
        app.add_option("--depth-mm", depth_mm, "either side of the focus")
            ->check(CLI::Range(0.0, 10.0))
            ->capture_default_str();
        app.add_option("--bits", bits, "of the galvo's words")->check(CLI::IsMember({16, 18}))->capture_default_str();
        app.add_option("--anchor-mm", anchor, "place in h that was asked of the axes")->expected(3)->type_name("X Y Z");
        app.add_option("--reading-mm", reading, "what their encoders say there")->expected(3)->type_name("X Y Z");
        app.add_flag("--no-depth", no_depth, "do not tell the controller the depth");
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        sc::MachineConfig machine = sc::reference_machine();
        machine.galvo.word = bits == 18 ? sc::GalvoWord::bits18 : sc::GalvoWord::bits16;
        sc::bench::FieldOptions options;
        options.half = half_mm * 1e-3;
        options.depth = depth_mm * 1e-3;
        options.tell_depth = !no_depth;
        options.anchor = {anchor[0] * 1e-3, anchor[1] * 1e-3, anchor[2] * 1e-3};
        options.reading = {reading[0] * 1e-3, reading[1] * 1e-3, reading[2] * 1e-3};
        const auto figures = sc::bench::field_figures(sc::bench::read_field_numbers(numbers),
                                                      sc::sim::read_world_spec(world), machine, options);
        const nlohmann::ordered_json object{{"rms_um", figures.rms * 1e6},
                                            {"max_um", figures.max * 1e6},
                                            {"places", figures.places},
                                            {"clamped", figures.clamped}};
        std::printf("%s\n", object.dump(2).c_str());
        return 0;
    } catch (const sc::sim::WorldError& error) {
        std::fprintf(stderr, "scribecell-field-truth: %s\n", error.what());
        return kBadInput;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-field-truth: %s\n", error.what());
        return kFailed;
    }
}
