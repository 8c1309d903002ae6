// SPDX-License-Identifier: Apache-2.0
#include "host/formats/scan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "host/formats/byte_file.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/mesh.hpp"
#include "host/formats/pcd.hpp"
#include "host/formats/ply.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

/// The fields of a line; blanks, commas and semicolons separate.
void split(std::string_view line, std::vector<std::string_view>& fields) {
    fields.clear();
    std::size_t begin = std::string_view::npos;
    for (std::size_t i = 0; i <= line.size(); ++i) {
        const bool separator =
            i == line.size() || line[i] == ' ' || line[i] == '\t' || line[i] == ',' || line[i] == ';';
        if (!separator && begin == std::string_view::npos) {
            begin = i;
        } else if (separator && begin != std::string_view::npos) {
            fields.push_back(line.substr(begin, i - begin));
            begin = std::string_view::npos;
        }
    }
}

std::string_view bare_name(std::string_view field) {
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') {
        field = field.substr(1, field.size() - 2);
    }
    return field;
}

/// Columns of x, y, z by a line of names; as they come if it names none of them.
std::array<std::size_t, 3> columns_of(const TextCursor& text, const std::vector<std::string_view>& names) {
    std::array<std::size_t, 3> columns{0, 1, 2};
    int found = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string lower(1, static_cast<char>('x' + axis));
        const std::string upper(1, static_cast<char>('X' + axis));
        for (std::size_t i = 0; i < names.size(); ++i) {
            std::string_view name = bare_name(names[i]);
            name = name.starts_with("//") ? name.substr(2) : name;
            if (name == lower || name == upper || name == lower + "_mm") {
                columns[axis] = i;
                ++found;
                break;
            }
        }
    }
    if (found != 0 && found != 3) {
        text.fail("the line of names lacks one of x, y, z", names.front(), "name the columns x, y and z");
    }
    return columns;
}

std::vector<double> parse_text(const std::filesystem::path& path, std::string_view bytes) {
    TextCursor text(path, bytes);
    std::vector<double> out;
    std::vector<std::string_view> fields;
    std::array<std::size_t, 3> columns{0, 1, 2};
    bool names_allowed = true;
    bool lone_count = false;
    while (!text.at_end()) {
        const TextCursor here = text;
        const std::string_view line = text.rest_of_line();
        if (line.empty() || line.front() == '#') {
            continue;
        }
        split(line, fields);
        double first = 0.0;
        if (names_allowed && (line.starts_with("//") || (!fields.empty() && !parse_any_number(fields[0], first)))) {
            columns = columns_of(here, fields);
            names_allowed = line.starts_with("//");
            continue;
        }
        if (line.starts_with("//")) {
            continue;
        }
        if (out.empty() && fields.size() == 1 && !lone_count) {
            lone_count = true;  // some programs write the number of points first
            continue;
        }
        names_allowed = false;
        for (const std::size_t column : columns) {
            double value = 0.0;
            if (column >= fields.size()) {
                here.fail("a line has fewer than three numbers", line, "give x, y and z in every line");
            }
            if (!parse_any_number(fields[column], value)) {
                here.fail("not a number", fields[column], "write numbers with a decimal point");
            }
            out.push_back(value);
        }
    }
    return out;
}

struct Raw {
    std::vector<double> xyz;
    std::vector<std::uint32_t> view;
};

std::string lower_extension(const std::filesystem::path& path) {
    std::string text = path.extension().string();
    std::ranges::transform(text, text.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return text;
}

Raw parse_any(const std::filesystem::path& path) {
    const std::string extension = lower_extension(path);
    if (extension == ".stl" || extension == ".obj") {
        const MeshFile mesh = read_mesh(path, {.name = "m", .metres = 1.0});
        Raw raw;
        for (const Vec3& v : mesh.mesh.vertices) {
            raw.xyz.insert(raw.xyz.end(), {v.x, v.y, v.z});
        }
        return raw;
    }
    const ByteFile file(path);
    if (looks_like_ply(file.bytes())) {
        PlyContent ply = parse_ply(path, file.bytes());
        return {std::move(ply.xyz), std::move(ply.view)};
    }
    if (looks_like_pcd(file.bytes())) {
        return {parse_pcd(path, file.bytes()), {}};
    }
    if (file.bytes().substr(0, 4096).find('\0') != std::string_view::npos) {
        throw InputError({.file = path.string(),
                          .problem = "is no cloud that can be read",
                          .value = extension,
                          .action = "give PLY, PCD, XYZ, ASC, CSV or STL"});
    }
    return {parse_text(path, file.bytes()), {}};
}

}  // namespace

ScanFile read_scan(const std::filesystem::path& path, const LengthUnit& unit) {
    const Raw raw = parse_any(path);
    ScanFile out{.cloud = {}, .unit = unit, .read = raw.xyz.size() / 3};
    out.cloud.points.reserve(out.read);
    const bool views = raw.view.size() == out.read;
    for (std::size_t i = 0; i < out.read; ++i) {
        const Vec3 v{raw.xyz[3 * i], raw.xyz[3 * i + 1], raw.xyz[3 * i + 2]};
        if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) {
            ++out.not_finite;
            continue;
        }
        out.cloud.points.push_back(unit.metres * v);
        if (views) {
            out.cloud.view.push_back(raw.view[i]);
        }
    }
    if (out.read == 0) {
        throw InputError({.file = path.string(), .problem = "has no point", .action = "give a cloud with points"});
    }
    if (out.cloud.points.empty()) {
        throw InputError({.file = path.string(),
                          .problem = "has no finite point",
                          .value = "all " + std::to_string(out.read) + " are NaN or infinite",
                          .action = "scan again, or export what was measured"});
    }
    return out;
}

void write_ply(const std::filesystem::path& path, const PointCloud& cloud) {
    const bool views = cloud.view.size() == cloud.points.size() && !cloud.view.empty();
    std::string out = "ply\nformat binary_little_endian 1.0\ncomment millimetres\nelement vertex " +
                      std::to_string(cloud.points.size()) + "\nproperty float x\nproperty float y\nproperty float z\n" +
                      (views ? "property uint view\n" : "") + "end_header\n";
    std::size_t at = out.size();
    const std::size_t record = views ? 16 : 12;
    out.resize(at + record * cloud.points.size());
    for (std::size_t i = 0; i < cloud.points.size(); ++i, at += record) {
        const Vec3 v = 1e3 * cloud.points[i];
        const std::array<float, 3> place{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
        std::memcpy(out.data() + at, place.data(), 12);
        if (views) {
            std::memcpy(out.data() + at + 12, &cloud.view[i], 4);
        }
    }
    write_text_file(path, out);
}

}  // namespace sc::host
