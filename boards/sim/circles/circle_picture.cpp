// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/circles/circle_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include <png.h>

namespace sc::sim {
namespace {

constexpr int kFine = 8;  ///< sub-pixels each way

/// Distance on the plane from the circle's edge, mm.
double outside(const Circle& circle, const Camera& camera, double x, double y) {
    const Vec3 ray{(x - camera.middle_x) / camera.focal, (y - camera.middle_y) / camera.focal, 1.0};
    const double way = dot(circle.normal, circle.centre) / dot(circle.normal, ray);
    return norm(way * ray - circle.centre) - circle.radius;
}

/// Share of the disc at a place of the picture, 0 or 1 but for a soft edge one sub-pixel wide.
double cover_at(const Circle& circle, const Camera& camera, double x, double y) {
    constexpr double kStep = 0.01;
    // To a distance in pixels by the slope there.
    const double slope = std::hypot(outside(circle, camera, x + kStep, y) - outside(circle, camera, x - kStep, y),
                                    outside(circle, camera, x, y + kStep) - outside(circle, camera, x, y - kStep)) /
                         (2.0 * kStep);
    const double off = slope > 0.0 ? outside(circle, camera, x, y) / slope : -1e9;
    return std::clamp(0.5 - off * kFine, 0.0, 1.0);
}

void blur_rows(std::vector<float>& field, int width, int height, const std::vector<float>& kernel, bool rows) {
    const int reach = static_cast<int>(kernel.size() / 2);
    std::vector<float> out(field.size(), 0.0F);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            float sum = 0.0F;
            for (int i = 0; i <= 2 * reach; ++i) {
                const int k = i - reach;
                const int xx = rows ? std::clamp(x + k, 0, width - 1) : x;
                const int yy = rows ? y : std::clamp(y + k, 0, height - 1);
                sum += kernel[static_cast<std::size_t>(i)] *
                       field[static_cast<std::size_t>(yy) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(xx)];
            }
            out[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] = sum;
        }
    }
    field = std::move(out);
}

/// Adds what a circle covers of each pixel.
void add_cover(const Camera& camera, const Circle& circle, double blur, Light& cover) {
    const auto middle = seen_at(circle.centre, camera);
    const int reach =
        static_cast<int>(std::ceil(1.2 * circle.radius * camera.focal / circle.centre.z + 6.0 * blur)) + 4;
    const int left = static_cast<int>(std::lround(middle[0])) - reach;
    const int top = static_cast<int>(std::lround(middle[1])) - reach;
    const int size = (2 * reach + 1) * kFine;
    const auto cell = [size](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x);
    };
    std::vector<float> fine(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            fine[cell(x, y)] = static_cast<float>(
                cover_at(circle, camera, left + (x + 0.5) / kFine - 0.5, top + (y + 0.5) / kFine - 0.5));
        }
    }
    const double sigma = blur * kFine;
    const int half = static_cast<int>(std::ceil(4.0 * sigma));
    std::vector<double> kernel;
    double sum = 0.0;
    for (int k = -half; k <= half; ++k) {
        kernel.push_back(sigma > 0.0 ? std::exp(-0.5 * k * k / (sigma * sigma)) : 1.0);
        sum += kernel.back();
    }
    std::vector<float> narrow;
    narrow.reserve(kernel.size());
    for (const double value : kernel) {
        narrow.push_back(static_cast<float>(value / sum));
    }
    blur_rows(fine, size, size, narrow, true);
    blur_rows(fine, size, size, narrow, false);
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            const int column = left + x / kFine;
            const int row = top + y / kFine;
            if (column >= 0 && row >= 0 && column < camera.width && row < camera.height) {
                cover[static_cast<std::size_t>(row) * static_cast<std::size_t>(camera.width) +
                      static_cast<std::size_t>(column)] += static_cast<double>(fine[cell(x, y)]) / (kFine * kFine);
            }
        }
    }
}

}  // namespace

std::array<double, 2> seen_at(const Vec3& place, const Camera& camera) {
    return {camera.middle_x + camera.focal * place.x / place.z, camera.middle_y + camera.focal * place.y / place.z};
}

Light light_of(const Camera& camera, const std::vector<Circle>& circles, const Look& look) {
    Light cover(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height), 0.0);
    for (const Circle& circle : circles) {
        add_cover(camera, circle, look.blur, cover);
    }
    const double rise_x = 0.01 * look.rise * std::cos(look.rise_heading);
    const double rise_y = 0.01 * look.rise * std::sin(look.rise_heading);
    Light out;
    for (int row = 0; row < camera.height; ++row) {
        for (int column = 0; column < camera.width; ++column) {
            const double share = cover[static_cast<std::size_t>(row) * static_cast<std::size_t>(camera.width) +
                                       static_cast<std::size_t>(column)];
            const double bright = look.dark + look.contrast;
            // What is dark reflects less of the rising light, too.
            const double light =
                (bright + rise_x * (column - 0.5 * camera.width) + rise_y * (row - 0.5 * camera.height)) / bright;
            out.push_back(light * (bright - look.contrast * share));
        }
    }
    return out;
}

void write_picture(const std::filesystem::path& file, const Camera& camera, const Light& light, double noise,
                   Random& random) {
    std::normal_distribution<double> normal(0.0, 1.0);
    std::vector<std::uint8_t> bytes;
    bytes.reserve(light.size());
    for (const double value : light) {
        bytes.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(value + noise * normal(random)), 0L, 255L)));
    }
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(camera.width);
    image.height = static_cast<png_uint_32>(camera.height);
    image.format = PNG_FORMAT_GRAY;
    if (png_image_write_to_file(&image, file.c_str(), 0, bytes.data(), 0, nullptr) == 0) {
        throw std::runtime_error(file.string() + " cannot be written");
    }
}

}  // namespace sc::sim
