// SPDX-License-Identifier: Apache-2.0
#include "host/vision/grey_image.hpp"

#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>

#include <jpeglib.h>
#include <png.h>

#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr std::size_t kMostPixels = 100'000'000;

[[noreturn]] void fail(const std::filesystem::path& path, std::string problem, std::string value = {},
                       std::string action = "give a PNG, JPEG or binary PGM picture") {
    throw InputError(
        {.file = path.string(), .problem = std::move(problem), .value = std::move(value), .action = std::move(action)});
}

void check_size(const std::filesystem::path& path, std::size_t width, std::size_t height) {
    if (width == 0 || height == 0 || width > kMostPixels / height) {
        fail(path, "is no picture of a usable size", std::to_string(width) + " x " + std::to_string(height));
    }
}

GreyImage sized(std::size_t width, std::size_t height, int full_scale) {
    GreyImage image;
    image.width = static_cast<int>(width);
    image.height = static_cast<int>(height);
    image.full_scale = full_scale;
    image.pixel.resize(width * height);
    return image;
}

GreyImage read_png(const std::filesystem::path& path, std::string_view bytes) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    if (png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) == 0) {
        fail(path, "is a damaged PNG", png.message);
    }
    check_size(path, png.width, png.height);
    const bool deep = (png.format & PNG_FORMAT_FLAG_LINEAR) != 0;
    // libpng's simplified reading makes 16 bits linear; samples that already are grey and linear pass unchanged.
    png.format = deep ? PNG_FORMAT_LINEAR_Y : PNG_FORMAT_GRAY;
    GreyImage image = sized(png.width, png.height, deep ? 65535 : 255);
    std::vector<std::uint8_t> narrow;
    void* into = image.pixel.data();
    if (!deep) {
        narrow.resize(image.pixel.size());
        into = narrow.data();
    }
    if (png_image_finish_read(&png, nullptr, into, 0, nullptr) == 0) {
        fail(path, "is a damaged PNG", png.message);
    }
    for (std::size_t i = 0; i < narrow.size(); ++i) {
        image.pixel[i] = narrow[i];
    }
    return image;
}

struct JpegErrors {
    jpeg_error_mgr manager;
    std::jmp_buf back;
    std::array<char, JMSG_LENGTH_MAX> text;
};

[[noreturn]] void jpeg_fails(j_common_ptr info) {
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): libjpeg hands its first member back.
    auto* errors = reinterpret_cast<JpegErrors*>(info->err);
    errors->manager.format_message(info, errors->text.data());
    // NOLINTNEXTLINE(cert-err52-cpp): the way out that libjpeg asks for; nothing with a destructor lies between.
    std::longjmp(errors->back, 1);
}

/// Decodes into `image`; false with errors.text. No object with a destructor is made between setjmp and longjmp.
bool decode_jpeg(std::string_view bytes, JpegErrors& errors, GreyImage& image, std::vector<std::uint8_t>& row) {
    jpeg_decompress_struct info{};
    info.err = jpeg_std_error(&errors.manager);
    errors.manager.error_exit = jpeg_fails;
    // NOLINTNEXTLINE(cert-err52-cpp): the way out that libjpeg asks for.
    if (setjmp(errors.back) != 0) {
        jpeg_destroy_decompress(&info);
        return false;
    }
    jpeg_create_decompress(&info);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes of a file.
    jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
    jpeg_read_header(&info, TRUE);
    info.out_color_space = JCS_GRAYSCALE;
    if (info.image_width == 0 || info.image_height == 0 || info.image_width > kMostPixels / info.image_height) {
        std::snprintf(errors.text.data(), errors.text.size(), "%u x %u", info.image_width, info.image_height);
        jpeg_destroy_decompress(&info);
        return false;
    }
    image = sized(info.image_width, info.image_height, 255);
    row.resize(info.image_width);
    jpeg_start_decompress(&info);
    while (info.output_scanline < info.output_height) {
        const std::size_t start = std::size_t{info.output_scanline} * info.image_width;
        unsigned char* into = row.data();
        jpeg_read_scanlines(&info, &into, 1);
        for (std::size_t i = 0; i < row.size(); ++i) {
            image.pixel[start + i] = row[i];
        }
    }
    jpeg_finish_decompress(&info);
    jpeg_destroy_decompress(&info);
    return true;
}

GreyImage read_jpeg(const std::filesystem::path& path, std::string_view bytes) {
    JpegErrors errors{};
    GreyImage image;
    std::vector<std::uint8_t> row;
    if (!decode_jpeg(bytes, errors, image, row)) {
        fail(path, "is a damaged JPEG", errors.text.data());
    }
    return image;
}

/// Next whole number of a PGM header; comments are passed over.
std::size_t pgm_number(const std::filesystem::path& path, std::string_view bytes, std::size_t& at) {
    while (at < bytes.size() && (std::strchr(" \t\r\n", bytes[at]) != nullptr || bytes[at] == '#')) {
        if (bytes[at] == '#') {
            at = std::min(bytes.find('\n', at), bytes.size());
        } else {
            ++at;
        }
    }
    std::size_t value = 0;
    const std::size_t start = at;
    while (at < bytes.size() && bytes[at] >= '0' && bytes[at] <= '9' && value <= kMostPixels) {
        value = 10 * value + static_cast<std::size_t>(bytes[at] - '0');
        ++at;
    }
    if (at == start) {
        fail(path, "is a damaged PGM: a number of its header is missing");
    }
    return value;
}

GreyImage read_pgm(const std::filesystem::path& path, std::string_view bytes) {
    std::size_t at = 2;
    const std::size_t width = pgm_number(path, bytes, at);
    const std::size_t height = pgm_number(path, bytes, at);
    const std::size_t most = pgm_number(path, bytes, at);
    check_size(path, width, height);
    if (most != 255 && most != 65535) {
        fail(path, "is a PGM of an unknown depth", std::to_string(most),
             "save it with 255 or 65535 as its largest value");
    }
    ++at;
    const std::size_t wide = most == 255 ? 1 : 2;
    if (bytes.size() < at + wide * width * height) {
        fail(path, "is a PGM that ends early", std::to_string(bytes.size()) + " bytes");
    }
    GreyImage image = sized(width, height, static_cast<int>(most));
    for (std::size_t i = 0; i < image.pixel.size(); ++i) {
        const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(bytes[at + wide * i + k]); };
        image.pixel[i] = static_cast<std::uint16_t>(wide == 1 ? byte(0) : byte(0) << 8U | byte(1));
    }
    return image;
}

void write(const std::filesystem::path& path, png_image& png, const void* pixels) {
    png.version = PNG_IMAGE_VERSION;
    png_alloc_size_t size = 0;
    if (png_image_write_to_memory(&png, nullptr, &size, 0, pixels, 0, nullptr) == 0) {
        fail(path, "cannot be made", png.message, "make the picture smaller");
    }
    std::string bytes(size, '\0');
    if (png_image_write_to_memory(&png, bytes.data(), &size, 0, pixels, 0, nullptr) == 0) {
        fail(path, "cannot be made", png.message, "make the picture smaller");
    }
    bytes.resize(size);
    write_text_file(path, bytes);
}

}  // namespace

GreyImage read_image(const std::filesystem::path& path) {
    const std::string bytes = read_text_file(path);
    constexpr std::string_view kPng{"\x89PNG\r\n\x1a\n"};
    if (bytes.starts_with(kPng)) {
        return read_png(path, bytes);
    }
    if (bytes.starts_with("\xff\xd8\xff")) {
        return read_jpeg(path, bytes);
    }
    if (bytes.starts_with("P5")) {
        return read_pgm(path, bytes);
    }
    fail(path, "is neither PNG nor JPEG nor binary PGM; it begins with", shortened(bytes.substr(0, 8)));
}

void write_png(const std::filesystem::path& path, const GreyImage& image) {
    png_image png{};
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    if (image.full_scale > 255) {
        png.format = PNG_FORMAT_LINEAR_Y;
        write(path, png, image.pixel.data());
        return;
    }
    png.format = PNG_FORMAT_GRAY;
    const std::vector<std::uint8_t> narrow(image.pixel.begin(), image.pixel.end());
    write(path, png, narrow.data());
}

void write_png(const std::filesystem::path& path, const ColourImage& image) {
    png_image png{};
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = PNG_FORMAT_RGB;
    write(path, png, image.pixel.data());
}

}  // namespace sc::host
