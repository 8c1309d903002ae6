// SPDX-License-Identifier: Apache-2.0
#include "host/formats/job.hpp"

#include <algorithm>
#include <array>

#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/mark_settings.hpp"
#include "host/formats/text.hpp"
#include "host/formats/toml_reader.hpp"
#include "host/formats/toml_writer.hpp"

namespace sc::host {

namespace {

constexpr std::string_view kFormat = "scribecell-job";
constexpr std::string_view kFromTable = "table";
constexpr std::array kFrames{PlaceFrame::h, PlaceFrame::c, PlaceFrame::w};
constexpr Limits kCrossSizeMm{0.1, 200.0};
constexpr Limits kLineLengthMm{1.0, 2000.0};

PlaceFrame read_frame(TomlReader& table) { return kFrames[table.choice("frame", {"h", "c", "w"})]; }

FaceLine read_line(TomlReader& table) {
    FaceLine out;
    out.line = table.line();
    out.frame = read_frame(table);
    out.from = table.vector_mm("from_mm");
    out.to = table.vector_mm("to_mm");
    if (out.from == out.to) {
        table.fail("to_mm", "is the same place as from_mm, which makes no line", fixed(out.to.x * 1e3, 4),
                   "give the two ends of the line");
    }
    table.finish();
    return out;
}

JobFace read_face(TomlReader& table) {
    JobFace face;
    face.line = table.line();
    face.angle_deg = table.number("angle_deg");
    face.frame = read_frame(table);
    const std::string points = table.text("points");
    if (points != kFromTable) {
        face.points = beside(table.file(), points);
    } else if (face.frame != PlaceFrame::h) {
        table.fail("frame", "does not suit the table, whose points are in h", std::string(name_of(face.frame)),
                   "set frame = \"h\", or name a CSV file in points");
    }
    if (auto line = table.table_if("line")) {
        face.datum_line = read_line(*line);
    }
    table.finish();
    return face;
}

std::vector<JobFace> read_faces(TomlReader& root) {
    std::vector<JobFace> faces;
    for (TomlReader& table : root.tables("face")) {
        const JobFace face = read_face(table);
        const auto same = [&face](const JobFace& other) { return other.angle_deg == face.angle_deg; };
        if (std::ranges::any_of(faces, same)) {
            table.fail("angle_deg", "appears twice", decimal(face.angle_deg), "give every face once");
        }
        faces.push_back(face);
    }
    if (faces.empty()) {
        throw InputError({.file = root.file().string(),
                          .problem = "key is missing",
                          .value = "face",
                          .action = "add a [[face]] for every face that is to be burnt"});
    }
    return faces;
}

void read_settings(TomlReader& root, Job& job) {
    if (auto table = root.table_if("cross")) {
        const Length size = Length::from_si(table->number("size_mm", kCrossSizeMm) / 1e3);
        job.cross = CrossSettings{size, read_mark_settings(*table)};
        table->finish();
    }
    if (auto table = root.table_if("datum_line")) {
        const Length length = Length::from_si(table->number("length_mm", kLineLengthMm) / 1e3);
        job.datum_line = DatumLineSettings{length, read_mark_settings(*table)};
        table->finish();
    }
    if (!job.cross && !job.datum_line) {
        throw InputError({.file = root.file().string(),
                          .problem = "key is missing",
                          .value = "cross",
                          .action = "add [cross], [datum_line] or both: this job burns nothing"});
    }
}

void check_alignment(const Job& job) {
    if (job.c_from_w) {
        return;
    }
    for (const JobFace& face : job.faces) {
        const bool line_in_w = face.datum_line && face.datum_line->frame == PlaceFrame::w;
        if (face.frame == PlaceFrame::w || line_in_w) {
            throw InputError({.file = job.file.string(),
                              .line = line_in_w ? face.datum_line->line : face.line,
                              .problem = "frame w needs the workpiece's place in c",
                              .value = "w",
                              .action = "add [alignment] with rotation and translation_mm (c_from_w)"});
        }
    }
}

void read_paths(TomlReader& root, Job& job) {
    const auto from_table = [](const JobFace& face) { return face.points.empty(); };
    if (root.has("table") || std::ranges::any_of(job.faces, from_table)) {
        job.table = beside(job.file, root.text("table"));
    }
    job.calibration = beside(job.file, root.text("calibration"));
}

Job parse_job(const std::filesystem::path& path, std::string_view text) {
    TomlDocument document(path, text, kFormat);
    TomlReader& root = document.root();
    Job job;
    job.file = path;
    job.name = root.text("name");
    read_settings(root, job);
    if (auto table = root.table_if("alignment")) {
        job.c_from_w = Rigid<frame::C, frame::W>{table->rotation("rotation"), table->vector_mm("translation_mm")};
        table->finish();
    }
    job.faces = read_faces(root);
    read_paths(root, job);
    check_alignment(job);
    root.finish();
    return job;
}

void write_line(TomlWriter& out, const FaceLine& line) {
    out.table("face.line");
    out.text("frame", name_of(line.frame));
    out.vector("from_mm", line.from, 1e3);
    out.vector("to_mm", line.to, 1e3);
}

std::string rendered(const std::filesystem::path& path, const Job& job) {
    TomlWriter out(kFormat);
    out.text("name", job.name);
    if (!job.table.empty()) {
        out.text("table", stored_path(path, job.table));
    }
    out.text("calibration", stored_path(path, job.calibration));
    if (job.cross) {
        out.table("cross");
        out.number("size_mm", job.cross->size.si(), 1e3);
        write_mark_settings(out, job.cross->settings);
    }
    if (job.datum_line) {
        out.table("datum_line");
        out.number("length_mm", job.datum_line->length.si(), 1e3);
        write_mark_settings(out, job.datum_line->settings);
    }
    if (job.c_from_w) {
        out.table("alignment");
        out.rotation("rotation", job.c_from_w->rotation);
        out.vector("translation_mm", job.c_from_w->translation, 1e3);
    }
    for (const JobFace& face : job.faces) {
        out.item("face");
        out.number("angle_deg", face.angle_deg);
        out.text("frame", name_of(face.frame));
        out.text("points", face.points.empty() ? std::string(kFromTable) : stored_path(path, face.points));
        if (face.datum_line) {
            write_line(out, *face.datum_line);
        }
    }
    return out.str();
}

}  // namespace

std::string_view name_of(PlaceFrame frame) noexcept {
    switch (frame) {
        case PlaceFrame::h: return "h";
        case PlaceFrame::c: return "c";
        case PlaceFrame::w: return "w";
    }
    return "?";
}

Job read_job(const std::filesystem::path& path) { return parse_job(path, read_text_file(path)); }

void write_job(const std::filesystem::path& path, const Job& job) {
    const std::string text = rendered(path, job);
    static_cast<void>(parse_job(path, text));  // what would be refused is not written
    write_text_file(path, text);
}

}  // namespace sc::host
