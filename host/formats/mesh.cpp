// SPDX-License-Identifier: Apache-2.0
#include "host/formats/mesh.hpp"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "host/formats/byte_file.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/ply.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr std::size_t kStlHeader = 84;
constexpr std::size_t kStlRecord = 50;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Finds places that were seen before; open addressing, grows to twice the places at most half full.
class Welder {
public:
    explicit Welder(std::size_t corners) : slots_(std::bit_ceil(corners + 16), kNone) {}

    std::uint32_t add(const Vec3& v, std::vector<Vec3>& places) {
        const Vec3 p{v.x + 0.0, v.y + 0.0, v.z + 0.0};  // -0 and 0 are one place
        std::size_t slot = hash(p) & (slots_.size() - 1);
        while (slots_[slot] != kNone) {
            if (places[slots_[slot]] == p) {
                return slots_[slot];
            }
            slot = (slot + 1) & (slots_.size() - 1);
        }
        const auto index = static_cast<std::uint32_t>(places.size());
        slots_[slot] = index;
        places.push_back(p);
        return index;
    }

private:
    static std::size_t hash(const Vec3& p) noexcept {
        std::uint64_t h = 0x9e3779b97f4a7c15ULL;
        for (const double c : {p.x, p.y, p.z}) {
            h = (h ^ std::bit_cast<std::uint64_t>(c)) * 0xff51afd7ed558ccdULL;
            h ^= h >> 32U;
        }
        return static_cast<std::size_t>(h);
    }

    std::vector<std::uint32_t> slots_;
};

bool is_binary_stl(std::string_view bytes) {
    return bytes.size() >= kStlHeader &&
           bytes.size() == kStlHeader + kStlRecord * std::uint64_t{load<std::uint32_t>(bytes, 80)};
}

std::vector<Vec3> parse_binary_stl(const std::filesystem::path& file, std::string_view bytes) {
    const std::size_t count = load<std::uint32_t>(bytes, 80);
    std::vector<Vec3> corners(3 * count);
    for (std::size_t i = 0; i < 3 * count; ++i) {
        const std::size_t at = kStlHeader + (i / 3) * kStlRecord + 12 + (i % 3) * 12;
        const auto x = static_cast<double>(load<float>(bytes, at));
        const auto y = static_cast<double>(load<float>(bytes, at + 4));
        const auto z = static_cast<double>(load<float>(bytes, at + 8));
        if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z)) {
            fail_at_byte(file, at, "a corner is not finite", std::to_string(i / 3) + "th triangle", "export it again");
        }
        corners[i] = {x, y, z};
    }
    return corners;
}

std::vector<Vec3> parse_ascii_stl(const std::filesystem::path& file, std::string_view bytes) {
    TextCursor text(file, bytes);
    static_cast<void>(text.rest_of_line());
    std::vector<Vec3> corners;
    bool ended = false;
    for (std::string_view word = text.word(); !word.empty(); word = text.word()) {
        if (word == "vertex") {
            const double x = text.number("a corner's x");
            const double y = text.number("a corner's y");
            const double z = text.number("a corner's z");
            corners.push_back({x, y, z});
            ended = false;
        } else if (word == "endloop") {
            if (corners.size() % 3 != 0) {
                text.fail("a facet has not three corners", "", "an STL facet is a triangle: export it again");
            }
        } else if (word == "facet") {
            static_cast<void>(text.rest_of_line());
        } else if (word == "solid" || word == "endsolid") {
            static_cast<void>(text.rest_of_line());
            ended = true;
        } else if (word != "outer" && word != "loop" && word != "endfacet") {
            text.fail("not a word of an ASCII STL", word, "give an STL file, or name its kind by its ending");
        }
    }
    if (!ended) {
        text.fail("ends without endsolid", "", "give the whole file");
    }
    return corners;
}

std::uint32_t obj_index(const TextCursor& text, std::string_view word, std::size_t vertices) {
    const std::string_view number = word.substr(0, word.find('/'));
    double value = 0.0;
    const bool parsed = parse_any_number(number, value) && value == std::floor(value);
    const double index = value > 0.0 ? value - 1.0 : value + static_cast<double>(vertices);
    if (!parsed || value == 0.0 || index < 0.0 || index >= static_cast<double>(vertices)) {
        text.fail("a face names a vertex that is not there", word,
                  "there are " + std::to_string(vertices) + " vertices up to this line");
    }
    return static_cast<std::uint32_t>(index);
}

std::vector<Vec3> parse_obj(const std::filesystem::path& file, std::string_view bytes) {
    TextCursor text(file, bytes);
    std::vector<Vec3> vertices;
    std::vector<Vec3> corners;
    while (!text.at_end()) {
        const std::string_view word = text.word_in_line();
        if (word == "v") {
            const double x = text.number("a vertex' x");
            const double y = text.number("a vertex' y");
            const double z = text.number("a vertex' z");
            vertices.push_back({x, y, z});
        } else if (word == "f") {
            std::array<std::uint32_t, 2> fan{};
            std::size_t count = 0;
            for (std::string_view corner = text.word_in_line(); !corner.empty(); corner = text.word_in_line()) {
                const std::uint32_t index = obj_index(text, corner, vertices.size());
                if (count < 2) {
                    fan[count] = index;
                } else {
                    corners.insert(corners.end(), {vertices[fan[0]], vertices[fan[1]], vertices[index]});
                    fan[1] = index;
                }
                ++count;
            }
            if (count < 3) {
                text.fail("a face has fewer than three corners", "", "correct this line");
            }
        }
        static_cast<void>(text.rest_of_line());
    }
    return corners;
}

std::vector<Vec3> parse_ply_mesh(const std::filesystem::path& file, std::string_view bytes) {
    const PlyContent ply = parse_ply(file, bytes);
    std::vector<Vec3> corners;
    corners.reserve(ply.index.size());
    for (const std::size_t i : ply.index) {
        const Vec3 v{ply.xyz[3 * i], ply.xyz[3 * i + 1], ply.xyz[3 * i + 2]};
        if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) {
            throw InputError({.file = file.string(),
                              .problem = "a vertex of a triangle is not finite",
                              .value = "vertex " + std::to_string(i),
                              .action = "export the mesh again"});
        }
        corners.push_back(v);
    }
    if (corners.empty() && ply.vertices > 0) {
        throw InputError({.file = file.string(),
                          .problem = "has points but no triangles",
                          .value = std::to_string(ply.vertices) + " vertices",
                          .action = "give a mesh here; a cloud is given with --scan"});
    }
    return corners;
}

std::string lower_extension(const std::filesystem::path& path) {
    std::string text = path.extension().string();
    for (char& c : text) {
        c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
    return text;
}

std::vector<Vec3> parse_any(const std::filesystem::path& path, std::string_view bytes) {
    const std::string extension = lower_extension(path);
    if (looks_like_ply(bytes)) {
        return parse_ply_mesh(path, bytes);
    }
    if (extension == ".obj") {
        return parse_obj(path, bytes);
    }
    if (is_binary_stl(bytes)) {
        return parse_binary_stl(path, bytes);
    }
    if (bytes.starts_with("solid") && bytes.substr(0, 4096).find('\0') == std::string_view::npos) {
        return parse_ascii_stl(path, bytes);
    }
    if (extension == ".stl" && bytes.size() >= kStlHeader) {
        const std::uint64_t count = load<std::uint32_t>(bytes, 80);
        fail_at_byte(path, 80, "the count of triangles does not fit the file's size",
                     std::to_string(count) + " triangles, " + std::to_string(bytes.size()) + " bytes",
                     "give the whole file: a binary STL has 84 bytes and 50 a triangle");
    }
    throw InputError({.file = path.string(),
                      .problem = "is no mesh that can be read",
                      .value = extension,
                      .action = "give STL, PLY, OBJ or STEP"});
}

}  // namespace

TriangleMesh welded(std::span<const Vec3> corners) {
    TriangleMesh mesh;
    Welder welder(corners.size());
    mesh.triangles.reserve(corners.size() / 3);
    mesh.vertices.reserve(corners.size() / 5);
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
        const std::uint32_t a = welder.add(corners[i], mesh.vertices);
        const std::uint32_t b = welder.add(corners[i + 1], mesh.vertices);
        const std::uint32_t c = welder.add(corners[i + 2], mesh.vertices);
        if (a != b && b != c && c != a) {
            mesh.triangles.push_back({a, b, c});
        }
    }
    return mesh;
}

MeshFile read_mesh(const std::filesystem::path& path, const LengthUnit& unit) {
    const ByteFile file(path);
    const std::vector<Vec3> corners = parse_any(path, file.bytes());
    MeshFile out{.mesh = welded(corners), .unit = unit, .read = corners.size() / 3};
    out.dropped = out.read - out.mesh.triangles.size();
    if (out.mesh.triangles.empty()) {
        throw InputError({.file = path.string(),
                          .problem = "has no triangle with an area",
                          .value = std::to_string(out.read) + " triangles in the file",
                          .action = "export the part again"});
    }
    for (Vec3& v : out.mesh.vertices) {
        v = unit.metres * v;
    }
    return out;
}

void write_stl(const std::filesystem::path& path, const TriangleMesh& mesh) {
    std::string out(kStlHeader + kStlRecord * mesh.triangles.size(), '\0');
    const std::string_view title = "binary STL, millimetres";
    std::memcpy(out.data(), title.data(), title.size());
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    std::memcpy(out.data() + 80, &count, 4);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 v = 1e3 * mesh.vertices[mesh.triangles[i][k]];
            const std::array<float, 3> place{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
            std::memcpy(out.data() + kStlHeader + i * kStlRecord + 12 + k * 12, place.data(), 12);
        }
    }
    write_text_file(path, out);
}

}  // namespace sc::host
