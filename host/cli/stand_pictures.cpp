// SPDX-License-Identifier: Apache-2.0
#include "host/cli/stand_pictures.hpp"

#include <algorithm>

#include "host/bridge/errors.hpp"
#include "host/bridge/stop.hpp"
#include "host/formats/error.hpp"
#include "host/vision/spot.hpp"

namespace sc::host::cli {
namespace {

[[noreturn]] void refused(const std::filesystem::path& picture, const SpotRefusal& why) {
    throw InputError({.file = picture.string(),
                      .problem = std::string("the picture is refused (") + name_of(why.problem) + ")",
                      .value = {},
                      .action = why.text});
}

}  // namespace

std::vector<PlatePixels> pixels_of(const Stand& stand) {
    std::vector<PlatePixels> out;
    for (const StandHeight& height : stand.heights) {
        PlatePixels plate;
        plate.z = height.z;
        const auto dots = find_dots(read_image(height.scale_picture), stand.dots.size());
        if (!dots) {
            refused(height.scale_picture, dots.error());
        }
        for (const Spot& dot : *dots) {
            plate.dots.push_back({dot.x, dot.y});
        }
        for (std::size_t i = 0; i < height.spots.size(); ++i) {
            if (stop_requested()) {
                throw Interrupted();
            }
            const auto spot = find_spot(read_image(height.spots[i]));
            if (!spot) {
                refused(height.spots[i], spot.error());
            }
            plate.spots[i] = {spot->x, spot->y};
            plate.spot_sigma = std::max(plate.spot_sigma, spot->sigma);
        }
        out.push_back(plate);
    }
    return out;
}

std::vector<StationFile> readings_of(const Stand& stand) {
    std::vector<StationFile> out;
    for (const StandHeight& height : stand.heights) {
        out.push_back(height.readings.empty() ? StationFile{} : read_stations(height.readings));
    }
    return out;
}

}  // namespace sc::host::cli
