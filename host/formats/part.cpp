// SPDX-License-Identifier: Apache-2.0
#include "host/formats/part.hpp"

#include <set>

#include "host/formats/file.hpp"
#include "host/formats/part_plain.hpp"
#include "host/formats/text.hpp"
#include "host/formats/toml_reader.hpp"
#include "host/formats/toml_writer.hpp"

namespace sc::host {

namespace {

constexpr std::string_view kFormat = "scribecell-part";
constexpr Limits kSizeMm{0.001, 1e5};
constexpr Limits kAllowanceMm{0.0, 1000.0};

/// Ids are unique in the whole file: a report names a feature by its id alone.
class Ids {
public:
    std::string read(TomlReader& table) {
        const std::string id = table.text("id");
        if (!seen_.insert(id).second) {
            table.fail("id", "appears twice", shortened(id), "give every entry an id of its own");
        }
        return id;
    }

private:
    std::set<std::string> seen_;
};

MachinedFeature read_feature(TomlReader& table, Ids& ids) {
    MachinedFeature out;
    out.id = ids.read(table);
    out.kind = table.choice("kind", {"plane", "bore"}) == 0 ? FeatureKind::plane : FeatureKind::bore;
    out.point.v = table.vector_mm("point_mm");
    out.min_allowance = table.number("min_allowance_mm", kAllowanceMm) / 1e3;
    if (out.kind == FeatureKind::plane) {
        out.direction.v = table.unit_vector("normal");
    } else {
        out.direction.v = table.unit_vector("axis");
        out.axis_point.v = table.vector_mm("axis_point_mm");
        out.diameter = table.number("diameter_mm", kSizeMm) / 1e3;
        out.depth = table.number_or("depth_mm", 0.0, {0.0, kSizeMm.most}) / 1e3;
    }
    table.finish();
    return out;
}

DatumPlane read_datum(TomlReader& table, Ids& ids) {
    DatumPlane out;
    out.id = ids.read(table);
    out.point.v = table.vector_mm("point_mm");
    out.normal.v = table.unit_vector("normal");
    out.note = table.text_or("note", "");
    table.finish();
    return out;
}

ReferencePoint read_reference(TomlReader& table, Ids& ids) {
    ReferencePoint out;
    out.id = ids.read(table);
    out.level = static_cast<int>(table.integer("level", 1, 3));
    out.point.v = table.vector_mm("point_mm");
    out.normal.v = table.unit_vector("normal");
    table.finish();
    return out;
}

Part parse_part(const std::filesystem::path& path, std::string_view text) {
    TomlDocument document(path, text, kFormat);
    TomlReader& root = document.root();
    Part part;
    part.id = root.text("id");
    part.note = root.text_or("note", "");
    Ids ids;
    for (TomlReader& table : root.tables("machined")) {
        part.machined.push_back(read_feature(table, ids));
    }
    for (TomlReader& table : root.tables("datum")) {
        part.datums.push_back(read_datum(table, ids));
    }
    for (TomlReader& table : root.tables("reference_point")) {
        part.reference_points.push_back(read_reference(table, ids));
    }
    if (auto table = root.table_if("as_cast")) {
        part.as_cast =
            AsCastBand{table->number("inside_mm", kAllowanceMm) / 1e3, table->number("outside_mm", kAllowanceMm) / 1e3};
        table->finish();
    }
    root.finish();
    return part;
}

void write_feature(TomlWriter& out, const MachinedFeature& feature) {
    const bool bore = feature.kind == FeatureKind::bore;
    out.item("machined");
    out.text("id", feature.id);
    out.text("kind", bore ? "bore" : "plane");
    out.vector("point_mm", feature.point.v, 1e3);
    out.vector(bore ? "axis" : "normal", feature.direction.v);
    if (bore) {
        out.vector("axis_point_mm", feature.axis_point.v, 1e3);
        out.number("diameter_mm", feature.diameter, 1e3);
        out.number("depth_mm", feature.depth, 1e3);
    }
    out.number("min_allowance_mm", feature.min_allowance, 1e3);
}

std::string rendered(const Part& part) {
    TomlWriter out(kFormat);
    out.text("id", part.id);
    out.text_unless_empty("note", part.note);
    for (const MachinedFeature& feature : part.machined) {
        write_feature(out, feature);
    }
    for (const DatumPlane& datum : part.datums) {
        out.item("datum");
        out.text("id", datum.id);
        out.vector("point_mm", datum.point.v, 1e3);
        out.vector("normal", datum.normal.v);
        out.text_unless_empty("note", datum.note);
    }
    for (const ReferencePoint& point : part.reference_points) {
        out.item("reference_point");
        out.text("id", point.id);
        out.integer("level", point.level);
        out.vector("point_mm", point.point.v, 1e3);
        out.vector("normal", point.normal.v);
    }
    if (part.as_cast) {
        out.table("as_cast");
        out.number("inside_mm", part.as_cast->inside, 1e3);
        out.number("outside_mm", part.as_cast->outside, 1e3);
    }
    return out.str();
}

}  // namespace

Part read_part(const std::filesystem::path& path) {
    const std::string text = read_text_file(path);
    return is_plain_part(path, text) ? parse_plain_part(path, text) : parse_part(path, text);
}

void write_part(const std::filesystem::path& path, const Part& part) {
    const std::string text = rendered(part);
    static_cast<void>(parse_part(path, text));  // what would be refused is not written
    write_text_file(path, text);
}

}  // namespace sc::host
