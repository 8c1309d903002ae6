// SPDX-License-Identifier: Apache-2.0
#include "boards/bench/field/field_truth.hpp"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>

#include "boards/sim/plant/galvo.hpp"
#include "boards/sim/world/world.hpp"
#include "firmware/laser/field_map.hpp"

namespace sc::bench {
namespace {

/// A sheet of 2 m at this y, facing the head.
sim::Mesh sheet(double y) {
    return {{{-1.0, y, -1.0}, {1.0, y, -1.0}, {1.0, y, 1.0}, {-1.0, y, 1.0}}, {{0, 2, 1}, {0, 3, 2}}};
}

/// What a head makes of a word, metres of command.
double command_of(std::uint32_t word, const GalvoConfig& galvo) {
    const bool wide = galvo.word == GalvoWord::bits18;
    const int range = wide ? 0x40000 : 0x10000;
    const auto data = wide ? sim::decode_xy2_100_18(word)
                           : sim::decode_xy2_100(word).transform([](std::uint16_t d) { return std::uint32_t{d}; });
    if (!data) {
        throw std::runtime_error("a word that no head takes");
    }
    int counts = static_cast<int>(*data);
    if (galvo.convention == GalvoConvention::offset_binary) {
        counts -= range / 2;
    } else if (counts >= range / 2) {
        counts -= range;
    }
    return counts / (galvo.counts_per_metre * (wide ? 4.0 : 1.0));
}

double at(std::size_t i, std::size_t count, double half) {
    return count > 1 ? half * (2.0 * static_cast<double>(i) / static_cast<double>(count - 1) - 1.0) : 0.0;
}

}  // namespace

FieldFigures field_figures(const GalvoField& field, const sim::WorldSpec& spec, const MachineConfig& machine,
                           const FieldOptions& options) {
    laser::FieldMap map(machine.galvo);
    map.set(field);
    FieldFigures figures;
    double sum = 0.0;
    for (std::size_t d = 0; d < options.depths; ++d) {
        const double depth = at(d, options.depths, options.depth);
        const sim::World world(spec, sheet(options.anchor.y + depth));
        for (std::size_t j = 0; j < options.side; ++j) {
            for (std::size_t i = 0; i < options.side; ++i) {
                const double x = at(i, options.side, options.half);
                const double z = at(j, options.side, options.half);
                const double told = options.tell_depth ? depth : 0.0;
                const laser::FieldPatch patch = map.patch(x, z, told);
                const auto counts = patch.counts({x, z, told});
                const auto words = patch.words({x, z, told});
                const auto spot = world.shine(options.reading, command_of(words[0], machine.galvo),
                                              command_of(words[1], machine.galvo), 0.0);
                if (!spot) {
                    throw std::runtime_error("a beam meets no sheet");
                }
                const double error =
                    std::hypot(spot->place.x - options.anchor.x - x, spot->place.z - options.anchor.z - z);
                sum += error * error;
                figures.max = std::max(figures.max, error);
                ++figures.places;
                const std::int32_t most = patch.format.most();
                figures.clamped += std::abs(counts[0]) == most || std::abs(counts[1]) == most ? 1U : 0U;
            }
        }
    }
    figures.rms = std::sqrt(sum / static_cast<double>(figures.places));
    return figures;
}

GalvoField read_field_numbers(const std::filesystem::path& file) {
    std::ifstream in(file);
    GalvoField field;
    std::string line;
    std::size_t count = 0;
    while (std::getline(in, line)) {
        char* end = nullptr;
        const double value = std::strtod(line.c_str(), &end);
        if (line.empty() || *end != '\0' || count == GalvoField::kNumbers) {
            throw std::runtime_error(file.string() + ": line " + std::to_string(count + 1) + " is not one of " +
                                     std::to_string(GalvoField::kNumbers) + " numbers");
        }
        field.set_number(count++, value);
    }
    if (count != GalvoField::kNumbers) {
        throw std::runtime_error(file.string() + " holds " + std::to_string(count) + " numbers, not " +
                                 std::to_string(GalvoField::kNumbers));
    }
    return field;
}

}  // namespace sc::bench
