// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/world/mesh.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string>
#include <string_view>

#include "boards/sim/world/world_error.hpp"

namespace sc::sim {
namespace {

constexpr std::array<std::string_view, 9> kSkipped{"vn", "vt", "vp", "o", "g", "s", "l", "usemtl", "mtllib"};

class ObjReader {
public:
    ObjReader(const std::filesystem::path& file, double unit) : file_(file), unit_(unit) {}

    Mesh read() {
        std::ifstream stream(file_);
        if (!stream) {
            throw WorldError({file_.string(), 0, "", "cannot be read", "check the path in the world file"});
        }
        std::string line;
        while (std::getline(stream, line)) {
            ++line_;
            split(line);
            if (!words_.empty()) {
                statement();
            }
        }
        if (mesh_.triangles.empty()) {
            throw WorldError({file_.string(), 0, "", "no triangle in the file", "export the mesh as ASCII OBJ"});
        }
        return std::move(mesh_);
    }

private:
    [[noreturn]] void refuse(std::string_view value, const std::string& problem, const std::string& action) const {
        throw WorldError({file_.string(), line_, std::string(value), problem, action});
    }

    void split(std::string_view line) {
        words_.clear();
        line = line.substr(0, line.find('#'));
        constexpr std::string_view kBlank = " \t\r";
        for (std::size_t begin = line.find_first_not_of(kBlank); begin != std::string_view::npos;) {
            const std::size_t end = std::min(line.find_first_of(kBlank, begin), line.size());
            words_.push_back(line.substr(begin, end - begin));
            begin = line.find_first_not_of(kBlank, end);
        }
    }

    void statement() {
        if (words_[0] == "v") {
            vertex();
        } else if (words_[0] == "f") {
            face();
        } else if (std::ranges::find(kSkipped, words_[0]) == kSkipped.end()) {
            refuse(words_[0], "unknown statement", "export the mesh as ASCII OBJ");
        }
    }

    [[nodiscard]] double number(std::string_view word) const {
        double value = 0.0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value)) {
            refuse(word, "not a finite number", "write it with a decimal point");
        }
        return value;
    }

    void vertex() {
        if (words_.size() < 4) {
            refuse("v", "a vertex needs three numbers", "write v x y z");
        }
        mesh_.vertices.push_back(unit_ * Vec3{number(words_[1]), number(words_[2]), number(words_[3])});
    }

    [[nodiscard]] std::uint32_t corner(std::string_view word) const {
        const std::string_view digits = word.substr(0, word.find('/'));
        long value = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        const long count = static_cast<long>(mesh_.vertices.size());
        const long index = value < 0 ? count + value : value - 1;
        if (error != std::errc{} || end != digits.data() + digits.size() || index < 0 || index >= count) {
            refuse(word, "no such vertex", "indices count the vertices above, from 1");
        }
        return static_cast<std::uint32_t>(index);
    }

    void face() {
        if (words_.size() < 4) {
            refuse("f", "a face needs three corners or more", "write f a b c");
        }
        const std::uint32_t first = corner(words_[1]);
        for (std::size_t i = 2; i + 1 < words_.size(); ++i) {
            add({first, corner(words_[i]), corner(words_[i + 1])});
        }
    }

    void add(const std::array<std::uint32_t, 3>& t) {
        const Vec3& a = mesh_.vertices[t[0]];
        if (!(norm(cross(mesh_.vertices[t[1]] - a, mesh_.vertices[t[2]] - a)) > 0.0)) {
            refuse("f", "a triangle without area", "remove it");
        }
        mesh_.triangles.push_back(t);
    }

    std::filesystem::path file_;
    double unit_;
    std::size_t line_ = 0;
    std::vector<std::string_view> words_;
    Mesh mesh_;
};

}  // namespace

Mesh read_obj(const std::filesystem::path& file, double unit) { return ObjReader(file, unit).read(); }

void append(Mesh& mesh, const Mesh& other) {
    const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const auto& t : other.triangles) {
        mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
    }
}

}  // namespace sc::sim
