// SPDX-License-Identifier: Apache-2.0
#include "host/formats/part_plain.hpp"

#include <set>
#include <string>

#include "host/formats/length_unit.hpp"
#include "host/formats/text.hpp"
#include "host/formats/toml_reader.hpp"

namespace sc::host {

namespace {

class PlainPart {
public:
    PlainPart(double metres, std::string stem) : metres_(metres) { part_.id = std::move(stem); }

    void read(TomlReader& root) {
        for (TomlReader& table : root.tables("machined")) {
            part_.machined.push_back(feature(table));
        }
        for (TomlReader& table : root.tables("datum")) {
            DatumPlane& out = part_.datums.emplace_back();
            out.id = id(table);
            out.point.v = place(table, "point");
            out.normal.v = table.unit_vector("normal");
            out.note = table.text_or("why", "");
            table.finish();
        }
        for (TomlReader& table : root.tables("rps")) {
            ReferencePoint& out = part_.reference_points.emplace_back();
            out.id = id(table);
            out.level = static_cast<int>(table.integer("level", 1, 3));
            out.point.v = place(table, "point");
            out.normal.v = table.unit_vector("normal");
            static_cast<void>(table.text_or("surface", ""));
            static_cast<void>(table.integer_or("scan_points_within_1_5mm", 0, 0, 1'000'000'000));
            table.finish();
        }
        if (auto band = root.table_if("as_cast")) {
            part_.as_cast = AsCastBand{length(*band, "inside"), length(*band, "outside")};
            band->finish();
        }
    }
    [[nodiscard]] Part& part() noexcept { return part_; }

private:
    std::string id(TomlReader& table) {
        const std::string text = table.text("id");
        if (!seen_.insert(text).second) {
            table.fail("id", "appears twice", shortened(text), "give every entry an id of its own");
        }
        return text;
    }
    Vec3 place(TomlReader& table, std::string_view key) const { return metres_ * table.vector(key); }
    double length(TomlReader& table, std::string_view key) const {
        return metres_ * table.number(key, {0.0, 1e3 / metres_});
    }
    MachinedFeature feature(TomlReader& table) {
        MachinedFeature out;
        out.id = id(table);
        out.kind = table.choice("kind", {"plane", "bore"}) == 0 ? FeatureKind::plane : FeatureKind::bore;
        out.point.v = place(table, "point");
        out.min_allowance = length(table, "min_allowance");
        if (out.kind == FeatureKind::plane) {
            out.direction.v = table.unit_vector("normal");
        } else {
            out.direction.v = table.unit_vector("axis");
            out.axis_point.v = place(table, "axis_point");
            out.diameter = length(table, "diameter");
            out.depth = table.has("depth") ? length(table, "depth") : 0.0;
        }
        // What the drawing says besides; the allowance is measured, not taken from here.
        if (table.has("nominal_allowance")) {
            static_cast<void>(table.number("nominal_allowance"));
        }
        if (table.has("feature_point")) {
            static_cast<void>(table.vector("feature_point"));
        }
        table.finish();
        return out;
    }

    double metres_;
    Part part_;
    std::set<std::string> seen_;
};

}  // namespace

bool is_plain_part(const std::filesystem::path& path, std::string_view text) {
    TomlDocument document(path, text, "");
    return document.root().has("units") && !document.root().has("format");
}

Part parse_plain_part(const std::filesystem::path& path, std::string_view text) {
    TomlDocument document(path, text, "");
    TomlReader& root = document.root();
    const std::string word = root.text("units");
    const auto unit = length_unit(word);
    if (!unit) {
        root.fail("units", "is no unit of length", shortened(word), "choose of: " + length_unit_names());
    }
    PlainPart reader(unit->metres, path.stem().string());
    Part& part = reader.part();
    const std::string frame = root.text_or("frame", "");
    part.note = frame.empty() ? std::string() : "frame of " + frame;
    if (root.text_or("default_surface", "as_cast") != "as_cast") {
        root.fail("default_surface", "is not known", root.text("default_surface"), "write \"as_cast\"");
    }
    reader.read(root);
    root.finish();
    return part;
}

}  // namespace sc::host
