// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/errors.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/subcommands.hpp"
#include "host/vision/spot.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kExamples = R"(Examples:
  scribecell vision spot beam.png
      centre and radius of the laser spot in a picture (PNG, JPEG, PGM; 8 or 16 bits)
  scribecell vision spot plate_*_spot_*.pgm --json
      one JSON object: for each picture centre, radius and quality, or why it was refused
  scribecell vision markers target.png --svg overlay.svg
      centres of circular markers
  scribecell vision stereo --left l.png --right r.png --calibration pair.toml
      places of the markers that a calibrated pair sees
  scribecell vision board --pictures view*.png --board 9x6 --square 25 --camera camera.toml
      where a board stands before a calibrated camera

Pixels: (0, 0) is the middle of the first pixel, y down.
Exit codes: 0 every picture has a centre; 1 one was refused; 2 bad input or usage.)";

struct Words {
    std::vector<std::string> images;
    bool json = false;
};

Json json_of(const std::string& file, const std::expected<Spot, SpotRefusal>& found) {
    if (!found) {
        return {{"image", file},
                {"found", false},
                {"problem", name_of(found.error().problem)},
                {"text", found.error().text}};
    }
    const Spot& spot = *found;
    return {{"image", file},
            {"found", true},
            {"x_px", spot.x},
            {"y_px", spot.y},
            {"radius_px", spot.radius},
            {"quality",
             {{"sigma_px", spot.sigma},
              {"roundness", spot.roundness},
              {"contrast", spot.contrast},
              {"saturated", spot.saturated},
              {"edge_points", spot.edge_points}}},
            {"edge_circle", {{"x_px", spot.edge.x}, {"y_px", spot.edge.y}, {"radius_px", spot.edge.radius}}}};
}

std::string text_of(const std::string& file, const std::expected<Spot, SpotRefusal>& found) {
    if (!found) {
        return fmt::format("{}: refused, {}\n", file, found.error().text);
    }
    return fmt::format("{}: centre ({:.3f}, {:.3f}) px, radius {:.2f} px, sigma {:.3f} px, {:.0f} % saturated\n", file,
                       found->x, found->y, found->radius, found->sigma, 100.0 * found->saturated);
}

int run(const Words& words) {
    install_stop_signals();
    Json all = Json::array();
    bool refused = false;
    for (const std::string& file : words.images) {
        if (stop_requested()) {
            throw Interrupted();
        }
        const auto found = find_spot(read_image(file));
        refused = refused || !found;
        if (words.json) {
            all.push_back(json_of(file, found));
        } else {
            std::fputs(text_of(file, found).c_str(), stdout);
        }
    }
    if (words.json) {
        std::printf("%s\n", Json{{"spots", all}}.dump(2).c_str());
    }
    return refused ? kFailed : kDone;
}

}  // namespace

void add_vision(CLI::App& app, int& exit_code) {
    CLI::App* vision = app.add_subcommand("vision", "What pictures show.");
    vision->require_subcommand(1);
    vision->footer(kExamples);
    CLI::App* sub = vision->add_subcommand("spot", "Centre and radius of a laser spot.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("images", words->images, "pictures")->required()->type_name("IMAGE...");
    sub->add_flag("--json", words->json, "one JSON object on stdout");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
    add_vision_markers(*vision, exit_code);
    add_vision_board(*vision, exit_code);
    add_vision_stereo(*vision, exit_code);
}

}  // namespace sc::host::cli
