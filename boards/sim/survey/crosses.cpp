// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/survey/crosses.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "boards/sim/camera/plate_camera.hpp"

namespace sc::sim {
namespace {

constexpr std::int64_t kPauseNs = 1'000'000;
constexpr double kPi = 3.14159265358979323846;
constexpr double kLeastSigma = 0.05e-6;  ///< what rounding leaves

/// Full width of the mark that a pulse leaves; 0: none.
double mark_width(const LaserTruth& laser, const trace::PulseRecord& pulse) {
    const double along = static_cast<double>(pulse.defocus_pm) * 1e-12 / laser.rayleigh_length;
    const double square = laser.waist * laser.waist * (1.0 + along * along);
    const double peak = 2.0 * static_cast<double>(pulse.energy_nj) * 1e-9 / (kPi * square);
    const double over = std::log(peak / laser.mark_threshold);
    return pulse.hit == 1 && over > 0.0 ? 2.0 * std::sqrt(0.5 * square * over) : 0.0;
}

/// Median width of each stroke.
std::vector<double> stroke_widths(const LaserTruth& laser, const std::vector<trace::PulseRecord>& pulses) {
    std::vector<double> out;
    std::vector<double> stroke;
    std::int64_t last = 0;
    const auto close = [&] {
        if (!stroke.empty()) {
            const auto middle = stroke.begin() + static_cast<std::ptrdiff_t>(stroke.size() / 2);
            std::ranges::nth_element(stroke, middle);
            out.push_back(*middle);
            stroke.clear();
        }
    };
    for (const trace::PulseRecord& pulse : pulses) {
        if (pulse.t_ns - last > kPauseNs) {
            close();
        }
        last = pulse.t_ns;
        stroke.push_back(mark_width(laser, pulse));
    }
    close();
    return out;
}

}  // namespace

void write_crosses(const CellTruth& truth, const World& world, const std::filesystem::path& trace,
                   const std::filesystem::path& folder) {
    const auto pulses = read_pulses(trace);
    const auto crosses = find_plate_crosses(pulses);
    const auto widths = stroke_widths(world.spec().laser, pulses);
    if (widths.size() != 2 * crosses.size()) {
        throw std::runtime_error("strokes and crosses do not belong together");
    }
    Random random = truth.random(11);
    Vec3 middle;
    for (const SeenCross& cross : crosses) {
        middle = middle + (1.0 / static_cast<double>(crosses.size())) * cross.place;
    }
    const Pose h_from_c = truth.look(middle, {0.25, 1.0, 0.35}, 0.5);
    const Pose c_from_h = h_from_c.inverse();
    const double sigma = truth.noise().marker;
    const double width_sigma = truth.noise().width;
    std::string text = "no,x,y,z,sigma_x,sigma_y,sigma_z,width,sigma_width\n";
    for (std::size_t i = 0; i < crosses.size(); ++i) {
        const Vec3 seen = c_from_h * crosses[i].place + normal_place(random, {sigma, sigma, sigma});
        const double width =
            0.5 * (widths[2 * i] + widths[2 * i + 1]) + width_sigma * normal_draw(random) / std::sqrt(2.0);
        const double stated = std::max(sigma, kLeastSigma) * 1e3;
        text += text_of("%zu,", i + 1) + text_mm(seen) + text_of(",%.7f,%.7f,%.7f,", stated, stated, stated);
        text += width > 0.0
                    ? text_of("%.7f,%.7f\n", width * 1e3, std::max(width_sigma, kLeastSigma) / std::sqrt(2.0) * 1e3)
                    : std::string("0,0\n");
    }
    ViewFiles files(truth, false);
    files.add("plate", h_from_c, 0.0, {}, random);
    files.write(folder);
    write_text(folder / "crosses.csv", text);
}

void write_widths(const CellTruth& truth, const World& world, const std::filesystem::path& trace,
                  const std::filesystem::path& file) {
    Random random = truth.random(12);
    std::string text = "line,width_mm,sigma_mm\n";
    std::size_t line = 0;
    const double sigma = truth.noise().width;
    for (const double width : stroke_widths(world.spec().laser, read_pulses(trace))) {
        const double seen = width + sigma * normal_draw(random);
        ++line;
        if (width > 0.0 && seen > 0.0) {
            text += text_of("%zu,%.7f,%.7f\n", line, seen * 1e3, std::max(sigma, kLeastSigma) * 1e3);
        }
    }
    write_text(file, text);
}

}  // namespace sc::sim
