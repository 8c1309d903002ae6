// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/station/picture.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

namespace sc::sim {
namespace {

constexpr double kReach = 2.5;     ///< waists: beyond, the light is 4e-6 of the peak
constexpr double kSoftEdge = 0.8;  ///< px: blur of the lens
constexpr int kMostPatterns = 200;

struct Box {
    int left;
    int top;
    int width;
    int height;
};

using Field = std::vector<double>;

std::size_t cell(const Box& box, int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(box.width) + static_cast<std::size_t>(x);
}

/// White noise, smoothed by a Gaussian of `grain` px along rows, then along columns.
Field smooth_noise(const Box& box, double grain, Random& random) {
    std::normal_distribution<double> normal;
    Field field(static_cast<std::size_t>(box.width) * static_cast<std::size_t>(box.height));
    for (double& v : field) {
        v = normal(random);
    }
    const int reach = static_cast<int>(std::ceil(3.0 * grain));
    std::vector<double> kernel;
    for (int k = -reach; k <= reach; ++k) {
        kernel.push_back(std::exp(-0.5 * k * k / (grain * grain)));
    }
    const auto pass = [&](bool rows) {
        Field out(field.size(), 0.0);
        for (int y = 0; y < box.height; ++y) {
            for (int x = 0; x < box.width; ++x) {
                double sum = 0.0;
                for (std::size_t i = 0; i < kernel.size(); ++i) {
                    const int k = static_cast<int>(i) - reach;
                    // Wrapped at the edges: the statistics stay the same everywhere.
                    const int xx = rows ? (x + k + box.width) % box.width : x;
                    const int yy = rows ? y : (y + k + box.height) % box.height;
                    sum += kernel[i] * field[cell(box, xx, yy)];
                }
                out[cell(box, x, y)] = sum;
            }
        }
        field = std::move(out);
    };
    pass(true);
    pass(false);
    return field;
}

/// Speckle of mean 1: fully developed patterns of |complex field|², averaged until the contrast is as asked.
Field speckle_of(const Box& box, double contrast, double grain, Random& random) {
    const std::size_t size = static_cast<std::size_t>(box.width) * static_cast<std::size_t>(box.height);
    if (!(contrast > 0.0)) {
        return Field(size, 1.0);
    }
    const int patterns = std::clamp(static_cast<int>(std::lround(1.0 / (contrast * contrast))), 1, kMostPatterns);
    Field sum(size, 0.0);
    for (int p = 0; p < patterns; ++p) {
        const Field real = smooth_noise(box, grain, random);
        const Field imaginary = smooth_noise(box, grain, random);
        for (std::size_t i = 0; i < size; ++i) {
            sum[i] += real[i] * real[i] + imaginary[i] * imaginary[i];
        }
    }
    // By what the smoothing leaves of the variance, not by what this pattern happens to have.
    double left = 0.0;
    const int reach = static_cast<int>(std::ceil(3.0 * grain));
    for (int k = -reach; k <= reach; ++k) {
        left += std::exp(-1.0 * k * k / (grain * grain));
    }
    const double mean = 2.0 * patterns * left * left;
    for (double& v : sum) {
        v /= mean;
    }
    return sum;
}

}  // namespace

void add_spot(Picture& picture, const SpotLook& look, Random& random) {
    const int reach = static_cast<int>(std::ceil(kReach * look.waist * look.stretch));
    const Box box{static_cast<int>(std::lround(look.centre[0])) - reach,
                  static_cast<int>(std::lround(look.centre[1])) - reach, 2 * reach + 1, 2 * reach + 1};
    const Field speckle = speckle_of(box, look.speckle, look.grain, random);
    const double c = std::cos(look.heading);
    const double s = std::sin(look.heading);
    for (int y = 0; y < box.height; ++y) {
        for (int x = 0; x < box.width; ++x) {
            const int column = box.left + x;
            const int row = box.top + y;
            if (column < 0 || row < 0 || column >= picture.width() || row >= picture.height()) {
                continue;
            }
            const double dx = column - look.centre[0];
            const double dy = row - look.centre[1];
            const double along = (dx * c + dy * s) / (look.waist * look.stretch);
            const double across = (dy * c - dx * s) / look.waist;
            picture.at(column, row) +=
                look.peak * std::exp(-2.0 * (along * along + across * across)) * speckle[cell(box, x, y)];
        }
    }
}

void add_gradient(Picture& picture, double rise, double heading) {
    const double c = std::cos(heading) / picture.width();
    const double s = std::sin(heading) / picture.height();
    const double middle_x = 0.5 * picture.width();
    const double middle_y = 0.5 * picture.height();
    for (int row = 0; row < picture.height(); ++row) {
        for (int column = 0; column < picture.width(); ++column) {
            picture.at(column, row) += rise * ((column - middle_x) * c + (row - middle_y) * s);
        }
    }
}

void add_disc(Picture& picture, const std::array<double, 2>& centre, const std::array<double, 2>& half_a,
              const std::array<double, 2>& half_b, double light) {
    const double determinant = half_a[0] * half_b[1] - half_a[1] * half_b[0];
    const double radius = std::sqrt(std::abs(determinant));
    const int reach = static_cast<int>(std::ceil(radius * 1.3)) + 4;
    const int column0 = static_cast<int>(std::lround(centre[0]));
    const int row0 = static_cast<int>(std::lround(centre[1]));
    for (int row = std::max(0, row0 - reach); row < std::min(picture.height(), row0 + reach); ++row) {
        for (int column = std::max(0, column0 - reach); column < std::min(picture.width(), column0 + reach); ++column) {
            const double dx = column - centre[0];
            const double dy = row - centre[1];
            const double a = (dx * half_b[1] - dy * half_b[0]) / determinant;
            const double b = (dy * half_a[0] - dx * half_a[1]) / determinant;
            const double outside = (std::hypot(a, b) - 1.0) * radius;
            const double cover = 0.5 * std::erfc(outside / (std::sqrt(2.0) * kSoftEdge));
            double& there = picture.at(column, row);
            there = (1.0 - cover) * there + cover * light;
        }
    }
}

void write_picture(const std::filesystem::path& file, const Picture& picture, double sigma, Random& random) {
    std::normal_distribution<double> normal;
    std::string bytes = "P5\n" + std::to_string(picture.width()) + " " + std::to_string(picture.height()) + "\n255\n";
    for (int row = 0; row < picture.height(); ++row) {
        for (int column = 0; column < picture.width(); ++column) {
            const double light = std::min(picture.at(column, row), 1.0);
            const double seen = light + sigma * std::sqrt(1.0 + std::max(light, 0.0)) * normal(random);
            bytes += static_cast<char>(static_cast<unsigned char>(std::clamp(std::lround(255.0 * seen), 0L, 255L)));
        }
    }
    std::ofstream out(file, std::ios::binary);
    out << bytes;
    out.close();
    if (!out) {
        throw std::runtime_error(file.string() + " cannot be written");
    }
}

}  // namespace sc::sim
