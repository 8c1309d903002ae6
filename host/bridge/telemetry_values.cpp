// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/telemetry_values.hpp"

#include <span>
#include <sstream>

#include "host/formats/error.hpp"
#include "shared/path/item.hpp"

namespace sc::host {
namespace {

constexpr std::size_t kAxisC = 3;

bool is_angle(const link::TelemetryColumn& column, std::size_t element) {
    return column.group == link::TelemetryGroup::motion && element == kAxisC;
}

std::int64_t get(ByteReader& in, const link::TelemetryColumn& column) {
    switch (column.bytes) {
        case 1: return in.get<std::uint8_t>();
        case 2: return in.get<std::uint16_t>();
        default: return column.sign ? std::int64_t{in.get<std::int32_t>()} : std::int64_t{in.get<std::uint32_t>()};
    }
}

}  // namespace

double TelemetryValue::value() const noexcept {
    const link::TelemetryColumn& c = link::kTelemetryColumns[column];
    const auto number = static_cast<double>(raw);
    if (!c.place) {
        return number;
    }
    return is_angle(c, element) ? number / kWireUnitsPerDegree : number * 1e3 / kWireUnitsPerMetre;
}

std::optional<std::vector<TelemetryValue>> decode(const link::Telemetry& sample) {
    if ((sample.channels & ~link::kTelemetryChannels) != 0 || sample.values.size > sample.values.data.size()) {
        return std::nullopt;
    }
    ByteReader in(std::span(sample.values.data).first(sample.values.size));
    std::vector<TelemetryValue> values;
    for (std::size_t i = 0; i < link::kTelemetryColumns.size(); ++i) {
        const link::TelemetryColumn& column = link::kTelemetryColumns[i];
        for (std::size_t k = 0; ((sample.channels >> i) & 1U) != 0 && k < column.count; ++k) {
            values.push_back({i, k, get(in, column)});
        }
    }
    return in.exhausted() ? std::optional(values) : std::nullopt;
}

std::string column_name(std::size_t column, std::size_t element) {
    const link::TelemetryColumn& c = link::kTelemetryColumns.at(column);
    std::string name(c.name);
    if (c.group == link::TelemetryGroup::motion) {
        name += std::string("_") + "xyzc"[element];
    } else if (c.count > 1) {
        name += "_" + std::to_string(element + 1);
    }
    return name + (!c.place ? "" : (is_angle(c, element) ? "_deg" : "_mm"));
}

std::uint32_t read_channels(const std::string& names) {
    std::uint32_t bits = 0;
    std::istringstream words(names);
    for (std::string word; std::getline(words, word, ',');) {
        std::uint32_t found = word == "all" ? link::kTelemetryChannels : 0;
        std::string known = "all";
        for (std::size_t i = 0; i < link::kTelemetryColumns.size(); ++i) {
            found |= word == link::kTelemetryColumns[i].name ? std::uint32_t{1} << i : 0U;
            known += ", " + std::string(link::kTelemetryColumns[i].name);
        }
        if (found == 0) {
            throw InputError(
                {.file = {}, .problem = "there is no such channel", .value = word, .action = "use some of: " + known});
        }
        bits |= found;
    }
    if (bits == 0) {
        throw InputError({.file = {},
                          .problem = "--channels names none",
                          .value = names,
                          .action = "name some, with commas between; scribecell telemetry --help lists them"});
    }
    return bits;
}

}  // namespace sc::host
