// SPDX-License-Identifier: Apache-2.0
#include "host/formats/scan_set.hpp"

#include <set>

#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"
#include "host/formats/toml_reader.hpp"
#include "host/formats/toml_writer.hpp"

namespace sc::host {

namespace {

constexpr std::string_view kFormat = "scribecell-scan-set";
constexpr Limits kSigmaUm{0.0, 1e5};

Rigid<frame::B, frame::F> read_pose(TomlReader& table) {
    const bool forward = table.choice("convention", {"b_from_f", "f_from_b"}) == 0;
    const Mat3 rotation = table.rotation("rotation");
    const Vec3 translation = table.vector_mm("translation_mm");
    table.finish();
    if (forward) {
        return {rotation, translation};
    }
    return Rigid<frame::F, frame::B>{rotation, translation}.inverse();
}

std::vector<ScanMarker> read_markers(TomlReader& view) {
    std::vector<ScanMarker> out;
    std::set<int> seen;
    for (TomlReader& table : view.tables("marker")) {
        ScanMarker marker;
        marker.id = static_cast<int>(table.integer("id", 0, 1'000'000));
        marker.place = table.vector_mm("place_mm");
        marker.sigma = table.number("sigma_um", kSigmaUm) / 1e6;
        table.finish();
        if (!seen.insert(marker.id).second) {
            table.fail("id", "appears twice in a view", std::to_string(marker.id), "keep one of them");
        }
        out.push_back(marker);
    }
    return out;
}

ScanView read_view(TomlReader& table) {
    ScanView view;
    view.line = table.line();
    view.id = table.text("id");
    view.c_deg = table.number("c_deg");
    if (auto pose = table.table_if("robot_pose")) {
        view.b_from_f = read_pose(*pose);
    }
    view.markers = read_markers(table);
    if (table.has("cloud")) {
        view.cloud = beside(table.file(), table.text("cloud"));
    }
    if (view.cloud.empty() && view.markers.empty()) {
        table.fail("id", "is a view with neither markers nor a cloud", shortened(view.id), "give one of them");
    }
    table.finish();
    return view;
}

ScanSet parse_scan_set(const std::filesystem::path& path, std::string_view text) {
    TomlDocument document(path, text, kFormat);
    TomlReader& root = document.root();
    ScanSet set{
        .file = path, .id = root.text("id"), .time = root.time("time"), .note = root.text_or("note", ""), .views = {}};
    std::set<std::string> seen;
    for (TomlReader& table : root.tables("view")) {
        set.views.push_back(read_view(table));
        if (!seen.insert(set.views.back().id).second) {
            table.fail("id", "appears twice", shortened(set.views.back().id), "give every view an id of its own");
        }
    }
    if (set.views.empty()) {
        throw InputError({.file = path.string(),
                          .problem = "key is missing",
                          .value = "view",
                          .action = "add a [[view]] for every picture"});
    }
    root.finish();
    return set;
}

void write_view(TomlWriter& out, const std::filesystem::path& path, const ScanView& view) {
    out.item("view");
    out.text("id", view.id);
    out.number("c_deg", view.c_deg);
    if (!view.cloud.empty()) {
        out.text("cloud", stored_path(path, view.cloud));
    }
    if (view.b_from_f) {
        out.table("view.robot_pose");
        out.text("convention", "b_from_f");
        out.rotation("rotation", view.b_from_f->rotation);
        out.vector("translation_mm", view.b_from_f->translation, 1e3);
    }
    for (const ScanMarker& marker : view.markers) {
        out.item("view.marker");
        out.integer("id", marker.id);
        out.vector("place_mm", marker.place, 1e3);
        out.number("sigma_um", marker.sigma, 1e6);
    }
}

}  // namespace

ScanSet read_scan_set(const std::filesystem::path& path) { return parse_scan_set(path, read_text_file(path)); }

void write_scan_set(const std::filesystem::path& path, const ScanSet& set) {
    TomlWriter out(kFormat);
    out.text("id", set.id);
    out.text("time", set.time);
    out.text_unless_empty("note", set.note);
    for (const ScanView& view : set.views) {
        write_view(out, path, view);
    }
    static_cast<void>(parse_scan_set(path, out.str()));  // what would be refused is not written
    write_text_file(path, out.str());
}

}  // namespace sc::host
