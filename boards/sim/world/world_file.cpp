// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include <toml++/toml.h>

#include "boards/sim/world/world_error.hpp"
#include "boards/sim/world/world_spec.hpp"

namespace sc::sim {
namespace {

constexpr int kVersion = 1;
constexpr int kMaxBases = 8;

/// Applies one file on top of a spec.
class Reader {
public:
    Reader(const std::filesystem::path& file, WorldSpec& spec) : file_(file), spec_(spec) {}

    void apply(const toml::table& root) {
        for (const auto& [key, node] : root) {
            const std::string name(key.str());
            if (name == "version") {
                check_version(node);
            } else if (name == "title") {
                spec_.title = text(node, name);
            } else if (name == "mesh") {
                read_meshes(node);
            } else if (name != "base") {
                walk(name, node);
            }
        }
    }

    /// A file without a base must give everything, so that nothing is zero by oversight.
    void require_all() const {
        std::string missing;
        const auto need = [&](const std::string& path) {
            if (!seen_.contains(path) && missing.empty()) {
                missing = path;
            }
        };
        for (const NumberKey& key : number_keys()) {
            need(key.path);
        }
        for (const FlagKey& key : flag_keys()) {
            need(key.path);
        }
        if (missing.empty() && spec_.meshes.empty()) {
            missing = "mesh";
        }
        if (!missing.empty()) {
            throw WorldError({file_.string(), 0, missing, "missing key", "give it, or name a base that has it"});
        }
    }

private:
    [[noreturn]] void refuse(const toml::node& node, const std::string& value, const std::string& problem,
                             const std::string& action) const {
        throw WorldError({file_.string(), node.source().begin.line, value, problem, action});
    }

    void check_version(const toml::node& node) const {
        if (node.value<std::int64_t>() != kVersion) {
            refuse(node, "version", "unknown version of the world format", "this program reads version 1");
        }
    }

    [[nodiscard]] std::string text(const toml::node& node, const std::string& name) const {
        if (!node.is_string()) {
            refuse(node, name, "not a text", "put it in quotes");
        }
        return node.ref<std::string>();
    }

    void walk(const std::string& path, const toml::node& node) {
        if (const toml::table* table = node.as_table()) {
            for (const auto& [key, child] : *table) {
                walk(path + "." + std::string(key.str()), child);
            }
            return;
        }
        const auto& numbers = number_keys();
        const auto number = std::ranges::find(numbers, path, &NumberKey::path);
        if (number != numbers.end()) {
            number->field(spec_) = read_number(*number, node) * number->si;
            seen_.insert(path);
            return;
        }
        const auto& flags = flag_keys();
        const auto flag = std::ranges::find(flags, path, &FlagKey::path);
        if (flag == flags.end()) {
            refuse(node, path, "unknown key", "remove it or correct its name; boards/sim/world/README.md lists all");
        }
        if (!node.is_boolean()) {
            refuse(node, path, "neither true nor false", "write true or false");
        }
        spec_.inputs.*(flag->field) = node.ref<bool>();
        seen_.insert(path);
    }

    [[nodiscard]] double read_number(const NumberKey& key, const toml::node& node) const {
        const auto value = node.is_number() ? node.value<double>() : std::nullopt;
        if (!value || !std::isfinite(*value)) {
            refuse(node, key.path, "not a finite number", "write a number such as 12.5");
        }
        if (*value < key.min || *value > key.max) {
            std::ostringstream limits;
            limits << "allowed: " << key.min << " to " << key.max;
            std::ostringstream shown;
            shown << key.path << " = " << *value;
            refuse(node, shown.str(), "out of its limits", limits.str());
        }
        return *value;
    }

    void read_meshes(const toml::node& node) {
        const toml::array* meshes = node.as_array();
        if (meshes == nullptr) {
            refuse(node, "mesh", "not a list of tables", "write [[mesh]]");
        }
        spec_.meshes.clear();
        for (const toml::node& entry : *meshes) {
            const toml::table* table = entry.as_table();
            if (table == nullptr) {
                refuse(entry, "mesh", "not a table", "write [[mesh]]");
            }
            spec_.meshes.push_back(read_mesh(*table));
        }
    }

    [[nodiscard]] MeshFile read_mesh(const toml::table& table) const {
        MeshFile mesh;
        for (const auto& [key, node] : table) {
            const std::string name(key.str());
            if (name == "name") {
                mesh.name = text(node, name);
            } else if (name == "file") {
                mesh.path = file_.parent_path() / text(node, name);
            } else if (name == "unit") {
                mesh.unit = read_unit(node);
            } else {
                refuse(node, "mesh." + name, "unknown key", "a mesh has name, file and unit");
            }
        }
        if (mesh.path.empty() || !table.contains("unit")) {
            refuse(table, "mesh", "file or unit is missing", "give both");
        }
        return mesh;
    }

    [[nodiscard]] double read_unit(const toml::node& node) const {
        const std::string unit = text(node, "unit");
        if (unit == "mm") {
            return 1e-3;
        }
        if (unit == "m") {
            return 1.0;
        }
        if (unit == "inch") {
            return 0.0254;
        }
        refuse(node, unit, "unknown unit", "use mm, m or inch");
    }

    std::filesystem::path file_;
    WorldSpec& spec_;
    std::set<std::string> seen_;
};

toml::table parse(const std::filesystem::path& file) {
    if (!std::filesystem::is_regular_file(file)) {
        throw WorldError({file.string(), 0, "", "no such file", "give the path of a world file"});
    }
    try {
        return toml::parse_file(file.string());
    } catch (const toml::parse_error& error) {
        throw WorldError({file.string(), error.source().begin.line, "", std::string(error.description()),
                          "correct the TOML syntax"});
    }
}

void read_into(const std::filesystem::path& file, WorldSpec& spec, int depth) {
    if (depth > kMaxBases) {
        throw WorldError({file.string(), 0, "base", "bases are nested deeper than eight", "break the circle"});
    }
    const toml::table root = parse(file);
    Reader reader(file, spec);
    const toml::node* base = root.get("base");
    if (base != nullptr) {
        if (!base->is_string()) {
            throw WorldError({file.string(), base->source().begin.line, "base", "not a text", "put it in quotes"});
        }
        read_into(file.parent_path() / base->ref<std::string>(), spec, depth + 1);
    }
    reader.apply(root);
    if (base == nullptr) {
        reader.require_all();
    }
}

}  // namespace

WorldSpec read_world_spec(const std::filesystem::path& file) {
    WorldSpec spec;
    read_into(file, spec, 0);
    return spec;
}

}  // namespace sc::sim
