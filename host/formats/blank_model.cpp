// SPDX-License-Identifier: Apache-2.0
#include "host/formats/blank_model.hpp"

#include <algorithm>

#include "host/formats/file.hpp"
#include "host/formats/length_unit.hpp"
#include "host/formats/text.hpp"
#include "host/formats/toml_reader.hpp"

namespace sc::host {

namespace {

class ModelReader {
public:
    ModelReader(TomlReader& root, double metres) : root_(&root), metres_(metres) {}

    BlankModel read() {
        TomlReader parameters = root_->table("parameters");
        out_.min_allowance = length(parameters, "min_allowance");
        out_.max_plane_allowance = length(parameters, "max_plane_z_allowance");
        for (TomlReader& table : root_->tables("part_zero")) {
            out_.zeros.push_back(
                {table.text("name"),
                 {{table.unit_vector("x_axis"), table.unit_vector("y_axis"), table.unit_vector("z_axis")}},
                 place(table, "optimum")});
        }
        for (TomlReader& table : root_->tables("feature")) {
            read_feature(table);
        }
        for (TomlReader& table : root_->tables("tolerance")) {
            BlankTolerance& t = out_.tolerances.emplace_back();
            t.id = std::to_string(table.integer("id", 0, 1'000'000));
            t.first = end_of(table, "f1");
            t.second = end_of(table, "f2");
            t.axis = table.choice("axis", {"x", "y", "z"});
            t.nominal = length(table, "nominal");
            t.lower = length(table, "lower");
            t.upper = length(table, "upper");
            if (!(t.lower < t.upper)) {
                table.fail("upper", "is not above lower", decimal(t.upper), "correct the tolerance");
            }
        }
        return std::move(out_);
    }

private:
    double length(TomlReader& table, std::string_view key) const { return metres_ * table.number(key, {-1e5, 1e5}); }
    Vec3 place(TomlReader& table, std::string_view key) const { return metres_ * table.vector(key); }

    void read_feature(TomlReader& table) {
        BlankFeature& f = out_.features.emplace_back();
        f.name = table.text("name");
        f.kind = table.choice("kind", {"plane", "bore"}) == 0 ? FeatureKind::plane : FeatureKind::bore;
        const std::string zero = table.text("part_zero");
        const auto found = std::ranges::find(out_.zeros, zero, &PartZero::name);
        if (found == out_.zeros.end()) {
            table.fail("part_zero", "is not among the part zeros", shortened(zero), "add a [[part_zero]] of that name");
        }
        f.zero = static_cast<std::size_t>(found - out_.zeros.begin());
        f.machined = place(table, "machined");
        f.rough = place(table, "rough");
        if (f.kind == FeatureKind::bore) {
            f.machined_radius = length(table, "machined_radius");
            f.rough_radius = length(table, "rough_radius");
        }
    }

    BlankTolerance::End end_of(TomlReader& table, const std::string& key) const {
        const std::string name = table.text(key);
        const auto found = std::ranges::find(out_.features, name, &BlankFeature::name);
        if (found == out_.features.end()) {
            table.fail(key, "is not among the features", shortened(name), "add a [[feature]] of that name");
        }
        return {static_cast<std::size_t>(found - out_.features.begin()),
                table.choice(key + "_state", {"rough", "machined"}) == 1};
    }

    TomlReader* root_;
    double metres_;
    BlankModel out_;
};

}  // namespace

BlankModel read_blank_model(const std::filesystem::path& path) {
    TomlDocument document(path, read_text_file(path), "");
    TomlReader& root = document.root();
    const std::string word = root.text("units");
    const auto unit = length_unit(word);
    if (!unit) {
        root.fail("units", "is no unit of length", shortened(word), "choose of: " + length_unit_names());
    }
    return ModelReader(root, unit->metres).read();
}

}  // namespace sc::host
