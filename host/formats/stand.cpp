// SPDX-License-Identifier: Apache-2.0
#include "host/formats/stand.hpp"

#include <cmath>
#include <numbers>
#include <set>

#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"
#include "host/formats/toml_reader.hpp"

namespace sc::host {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr Limits kLengthMm{1e-3, 100'000.0};
constexpr Limits kSmallUm{0.0, 1e5};
constexpr std::size_t kFewestHeights = 3;
constexpr std::size_t kFewestDots = 6;

void read_sensors(TomlReader& root, Stand& stand) {
    std::size_t count = 0;
    std::set<std::string> seen;
    for (TomlReader& table : root.tables("sensor")) {
        StandSensor sensor;
        sensor.id = table.text("id");
        const auto origin = table.numbers("origin_mm", 2);
        sensor.origin = {origin[0] / 1e3, origin[1] / 1e3};
        if (!seen.insert(sensor.id).second) {
            table.fail("id", "appears twice", shortened(sensor.id), "name each sensor once");
        }
        table.finish();
        if (count < stand.sensors.size()) {
            stand.sensors[count] = sensor;
        }
        ++count;
    }
    if (count != stand.sensors.size()) {
        root.fail("sensor", "are not three", std::to_string(count), "give a [[sensor]] for each beam");
    }
}

void read_dots(TomlReader& root, Stand& stand) {
    TomlReader table = root.table("dots");
    const std::vector<double> x = table.any_numbers("x_mm");
    const std::vector<double> y = table.any_numbers("y_mm");
    if (x.size() != y.size() || x.size() < kFewestDots) {
        table.fail("y_mm", "does not give six dots or more together with x_mm",
                   std::to_string(x.size()) + " and " + std::to_string(y.size()), "give x and y of every dot");
    }
    for (std::size_t i = 0; i < x.size(); ++i) {
        stand.dots.push_back({x[i] / 1e3, y[i] / 1e3});
    }
    stand.dot_diameter = table.number("diameter_mm", kLengthMm) / 1e3;
    stand.registration = table.number("registration_um", kSmallUm) / 1e6;
    table.finish();
}

void read_heights(TomlReader& root, Stand& stand) {
    std::set<double> seen;
    for (TomlReader& table : root.tables("height")) {
        StandHeight height;
        height.z = table.number("z_mm", kLengthMm) / 1e3;
        height.scale_picture = beside(stand.file, table.text("dots"));
        const auto spots = table.texts("spots");
        if (spots.size() != height.spots.size()) {
            table.fail("spots", "are not three pictures", std::to_string(spots.size()), "give one a sensor");
        }
        for (std::size_t i = 0; i < spots.size(); ++i) {
            height.spots[i] = beside(stand.file, spots[i]);
        }
        if (table.has("readings")) {
            height.readings = beside(stand.file, table.text("readings"));
        }
        if (!seen.insert(height.z).second) {
            table.fail("z_mm", "appears twice", decimal(height.z * 1e3), "each plate has a height of its own");
        }
        table.finish();
        stand.heights.push_back(height);
    }
    if (stand.heights.size() < kFewestHeights) {
        root.fail("height", "are fewer than three", std::to_string(stand.heights.size()),
                  "two plates leave nothing over to check a straight beam with: give three or more");
    }
}

}  // namespace

Stand read_stand(const std::filesystem::path& path) {
    TomlDocument document(path, read_text_file(path), "scribecell-stand");
    TomlReader& root = document.root();
    Stand stand;
    stand.file = path;
    stand.id = root.text("id");
    stand.time = root.time("time");
    const auto range = root.numbers("range_mm", 2);
    if (!(range[0] >= 0.0 && range[1] > range[0])) {
        root.fail("range_mm", "is no range", decimal(range[0]) + ", " + decimal(range[1]), "give least and most");
    }
    stand.range = {range[0] / 1e3, range[1] / 1e3};
    stand.sigma = root.number("sigma_um", {1e-3, 1e5}) / 1e6;
    stand.height_sigma = root.number("height_sigma_um", kSmallUm) / 1e6;
    read_sensors(root, stand);
    read_dots(root, stand);
    if (auto table = root.table_if("mount")) {
        StandMount mount;
        mount.arm = table->number("arm_mm", kLengthMm) / 1e3;
        mount.pitch = table->number("pitch_mm", kLengthMm) / 1e3;
        mount.clockwise_is_positive = table->choice("clockwise", {"positive", "negative"}) == 0;
        table->finish();
        stand.mount = mount;
    }
    if (auto table = root.table_if("reference")) {
        TripleReference reference{table->rotation("rotation"), table->vector_mm("translation_mm"), {}};
        Vec3 middle;
        for (const StandSensor& sensor : stand.sensors) {
            middle = middle + (1.0 / 3.0) * Vec3{sensor.origin[0], sensor.origin[1], 0.0};
        }
        const Vec3 in_r = reference.rotation.transposed() * (middle - reference.translation);
        reference.at = {in_r.y, in_r.z};
        if (table->has("at_mm")) {
            const auto at = table->numbers("at_mm", 2);
            reference.at = {at[0] / 1e3, at[1] / 1e3};
        }
        stand.reference = reference;
        stand.reference_angle_sigma = table->number("sigma_deg", {1e-6, 45.0}) * kDegree;
        stand.reference_place_sigma = table->number("sigma_mm", {1e-6, 1e3}) / 1e3;
        table->finish();
    }
    read_heights(root, stand);
    root.finish();
    return stand;
}

}  // namespace sc::host
