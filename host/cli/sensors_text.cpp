// SPDX-License-Identifier: Apache-2.0
#include "host/cli/sensors_text.hpp"

#include <fmt/format.h>

#include "host/bridge/errors.hpp"
#include "shared/codes/codes.hpp"
#include "shared/path/item.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 6> kQualities{"none", "good", "repeated", "stale", "out of range", "faulty"};
constexpr std::array<std::string_view, 5> kSurfaces{"not watched", "waiting", "fine", "not seen", "off"};

double mm(std::int32_t wire) { return static_cast<double>(wire) * 1e3 / kWireUnitsPerMetre; }
bool fitted(const link::SensorReport& report, std::size_t i) {
    return report.code.at(i) != static_cast<std::uint16_t>(Refusal::sensor_not_fitted);
}
std::string_view surface_name(std::uint8_t surface) { return surface < kSurfaces.size() ? kSurfaces.at(surface) : "?"; }

}  // namespace

std::string_view quality_name(const link::SensorReport& report, std::size_t i) {
    if (!fitted(report, i)) {
        return "not fitted";
    }
    return report.quality.at(i) < kQualities.size() ? kQualities.at(report.quality.at(i)) : "?";
}

std::string trouble_text(const link::SensorReport& report, std::size_t i) {
    if (report.code.at(i) == 0 || !fitted(report, i)) {
        return "";
    }
    std::string text = describe_code(report.code.at(i));
    if (report.detail.at(i) != 0) {
        text += fmt::format(", detail {}", report.detail.at(i));
    }
    return text;
}

std::string sensors_text(const link::SensorReport& report) {
    std::string text = fmt::format("{:<9} {:>12} {:>10}  {:<12} {:>8} {:>8} {:>6}\n", "sensor", "mm", "age ms",
                                   "quality", "measured", "repeats", "failed");
    for (std::size_t i = 0; i < kSensorNames.size(); ++i) {
        const bool read = report.count.at(i) > 0;
        const std::string value = read ? fmt::format("{:.4f}", mm(report.value.at(i))) : "-";
        const std::string age = read ? fmt::format("{:.1f}", report.age_us.at(i) * 1e-3) : "-";
        text += fmt::format("{:<9} {:>12} {:>10}  {:<12} {:>8} {:>8} {:>6}\n", kSensorNames.at(i), value, age,
                            quality_name(report, i), report.count.at(i), report.repeats.at(i), report.bad.at(i));
        const std::string trouble = trouble_text(report, i);
        if (!trouble.empty()) {
            text += "          " + trouble + "\n";
        }
    }
    text += fmt::format("surface   {}", surface_name(report.surface));
    if (report.surface >= 2) {
        text +=
            fmt::format(", at y = {:.3f} mm, focus shifted by {:+.3f} mm", mm(report.surface_depth), mm(report.shift));
    }
    return text + "\n";
}

Json sensors_json(const link::SensorReport& report) {
    Json sensors = Json::array();
    for (std::size_t i = 0; i < kSensorNames.size(); ++i) {
        Json one;
        one["name"] = kSensorNames.at(i);
        const bool read = report.count.at(i) > 0;
        one["value_mm"] = read ? Json(mm(report.value.at(i))) : Json();
        one["age_ms"] = read ? Json(report.age_us.at(i) * 1e-3) : Json();
        one["quality"] = quality_name(report, i);
        one["code"] = report.code.at(i);
        one["detail"] = report.detail.at(i);
        one["text"] = fitted(report, i) ? trouble_text(report, i) : describe_code(report.code.at(i));
        one["measured"] = report.count.at(i);
        one["repeats"] = report.repeats.at(i);
        one["failed"] = report.bad.at(i);
        one["last_failure"] = report.last_bad.at(i);
        sensors.push_back(std::move(one));
    }
    Json out;
    out["cell_seconds"] = static_cast<double>(report.cell_time_us) * 1e-6;
    out["sensors"] = std::move(sensors);
    out["surface"] = surface_name(report.surface);
    out["surface_y_mm"] = report.surface >= 2 ? Json(mm(report.surface_depth)) : Json();
    out["shift_mm"] = mm(report.shift);
    out["seating_deviation_mm"] = {mm(report.seating[0]), mm(report.seating[1]), mm(report.seating[2])};
    return out;
}

}  // namespace sc::host::cli
