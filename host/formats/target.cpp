// SPDX-License-Identifier: Apache-2.0
#include "host/formats/target.hpp"

#include <set>

#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/toml_reader.hpp"
#include "host/formats/toml_writer.hpp"

namespace sc::host {

namespace {

constexpr std::string_view kFormat = "scribecell-target";
constexpr std::int64_t kLargestId = 1'000'000;
constexpr Limits kSigmaUm{0.0, 1e5};
constexpr Limits kHeightMm{-1000.0, 1000.0};

TargetMarker read_marker(TomlReader& table) {
    TargetMarker out;
    out.id = static_cast<int>(table.integer("id", 0, kLargestId));
    out.place = table.vector_mm("place_mm");
    out.sigma = table.number("sigma_um", kSigmaUm) / 1e6;
    table.finish();
    return out;
}

TargetStep read_step(TomlReader& table, const std::set<int>& markers) {
    TargetStep out;
    out.id = static_cast<int>(table.integer("id", 0, kLargestId));
    out.height = table.number("height_mm", kHeightMm) / 1e3;
    out.uncertainty = table.number("uncertainty_um", kSigmaUm) / 1e6;
    for (const std::int64_t id : table.integers("markers")) {
        if (id < 0 || id > kLargestId || !markers.contains(static_cast<int>(id))) {
            table.fail("markers", "names a marker that the target does not have", std::to_string(id),
                       "add the marker, or correct its id");
        }
        out.markers.push_back(static_cast<int>(id));
    }
    table.finish();
    return out;
}

Target parse_target(const std::filesystem::path& path, std::string_view text) {
    TomlDocument document(path, text, kFormat);
    TomlReader& root = document.root();
    Target target;
    target.id = root.text("id");
    target.kind = root.choice("kind", {"fixed", "mobile"}) == 0 ? TargetKind::fixed : TargetKind::mobile;
    target.certificate = root.text_or("certificate", "");
    std::set<int> markers;
    for (TomlReader& table : root.tables("marker")) {
        target.markers.push_back(read_marker(table));
        if (!markers.insert(target.markers.back().id).second) {
            table.fail("id", "appears twice", std::to_string(target.markers.back().id), "keep one of them");
        }
    }
    std::set<int> steps;
    for (TomlReader& table : root.tables("step")) {
        target.steps.push_back(read_step(table, markers));
        if (!steps.insert(target.steps.back().id).second) {
            table.fail("id", "appears twice", std::to_string(target.steps.back().id), "keep one of them");
        }
    }
    if (target.markers.empty()) {
        throw InputError({.file = path.string(),
                          .problem = "key is missing",
                          .value = "marker",
                          .action = "add a [[marker]] for every marker of the target"});
    }
    root.finish();
    return target;
}

}  // namespace

Target read_target(const std::filesystem::path& path) { return parse_target(path, read_text_file(path)); }

void write_target(const std::filesystem::path& path, const Target& target) {
    TomlWriter out(kFormat);
    out.text("id", target.id);
    out.text("kind", target.kind == TargetKind::fixed ? "fixed" : "mobile");
    out.text_unless_empty("certificate", target.certificate);
    for (const TargetMarker& marker : target.markers) {
        out.item("marker");
        out.integer("id", marker.id);
        out.vector("place_mm", marker.place, 1e3);
        out.number("sigma_um", marker.sigma, 1e6);
    }
    for (const TargetStep& step : target.steps) {
        out.item("step");
        out.integer("id", step.id);
        out.number("height_mm", step.height, 1e3);
        out.number("uncertainty_um", step.uncertainty, 1e6);
        out.integers("markers", step.markers);
    }
    static_cast<void>(parse_target(path, out.str()));  // what would be refused is not written
    write_text_file(path, out.str());
}

}  // namespace sc::host
