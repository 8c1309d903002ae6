// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace sc::host {

/// A grey picture; row by row, pixel (column, row) has its centre at (column, row).
struct GreyImage {
    int width = 0;
    int height = 0;
    int full_scale = 255;              ///< of a pixel: 255 or 65535
    std::vector<std::uint16_t> pixel;  ///< width·height
    [[nodiscard]] std::uint16_t at(int column, int row) const {
        return pixel[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                     static_cast<std::size_t>(column)];
    }
};

/// Red, green, blue, 8 bits each, row by row.
struct ColourImage {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> pixel;  ///< 3·width·height
};

/// PNG (8 or 16 bit; colours become grey), JPEG, or binary PGM, told by its first bytes. Throws InputError: missing,
/// none of these, damaged, or larger than 100 million pixels.
[[nodiscard]] GreyImage read_image(const std::filesystem::path& path);

/// All or nothing, as write_text_file. Throws InputError.
void write_png(const std::filesystem::path& path, const GreyImage& image);
void write_png(const std::filesystem::path& path, const ColourImage& image);

}  // namespace sc::host
