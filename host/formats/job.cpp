// SPDX-License-Identifier: Apache-2.0
#include "host/formats/job.hpp"

#include <algorithm>
#include <array>

#include "host/formats/calibration_store.hpp"
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
constexpr Limits kArcFit{0.0, 0.9};  // what is left of the tolerance is the controller's
constexpr Limits kLineLengthMm{1.0, 2000.0};
constexpr Limits kWindowMm{0.01, 50.0};
constexpr Limits kBoundMm{0.01, 2.0};
constexpr Limits kLookSpeedMmS{1.0, 200.0};
constexpr Limits kSeatingMm{0.01, 50.0};
constexpr std::int64_t kMostSamples = 100;

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

std::vector<PathStep> read_steps(TomlReader& table) {
    std::vector<PathStep> steps;
    for (const TomlReader::Stop& stop : table.stops_mm("points_mm")) {
        steps.push_back({stop.line, stop.via, stop.to});
    }
    if (steps.size() < 2) {
        table.fail("points_mm", "holds fewer than two places", std::to_string(steps.size()),
                   "give the start and at least one place more");
    }
    if (steps.front().via) {
        table.fail("points_mm", "begins with an arc", "via", "give the place where the arc begins first: [x, y, z]");
    }
    return steps;
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
    return faces;
}

SeatingSettings read_seating(TomlReader& table) {
    SeatingSettings seating;
    const std::vector<double> expected = table.numbers("expected_mm", seating.expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        if (!(expected[i] > 0.0 && expected[i] <= 20'000.0)) {
            table.fail("expected_mm", "is no distance of a sensor", decimal(expected[i]),
                       "take the three over from `scribecell sensors --reference`");
        }
        seating.expected.at(i) = expected[i] / 1e3;
    }
    seating.tolerance = Length::from_si(table.number("tolerance_mm", kSeatingMm) / 1e3);
    seating.tilt = Length::from_si(table.number("tilt_mm", kSeatingMm) / 1e3);
    seating.samples = static_cast<int>(table.integer_or("samples", seating.samples, 1, kMostSamples));
    return seating;
}

void read_settings(TomlReader& root, Job& job, const Recipe* recipe) {
    if (auto table = root.table_if("cross")) {
        const Length size = Length::from_si(table->number("size_mm", kCrossSizeMm) / 1e3);
        job.cross = CrossSettings{size, read_mark_settings(*table, recipe)};
        table->finish();
    }
    if (auto table = root.table_if("datum_line")) {
        const Length length = Length::from_si(table->number("length_mm", kLineLengthMm) / 1e3);
        job.datum_line = DatumLineSettings{length, read_mark_settings(*table, recipe)};
        table->finish();
    }
    if (auto table = root.table_if("surface")) {
        SurfaceSettings surface;
        surface.follow = table->choice("mode", {"check", "follow"}) == 1;
        surface.window = Length::from_si(table->number("window_mm", kWindowMm) / 1e3);
        if (surface.follow) {
            surface.bound = Length::from_si(table->number("bound_mm", kBoundMm) / 1e3);
        }
        if (table->has("look_speed_mm_s")) {
            surface.look_speed = Speed::from_si(table->number("look_speed_mm_s", kLookSpeedMmS) / 1e3);
        }
        job.surface = surface;
        table->finish();
    }
    if (auto table = root.table_if("seating")) {
        job.seating = read_seating(*table);
        table->finish();
    }
    if (!job.cross && !job.datum_line && !root.has("path")) {
        throw InputError({.file = root.file().string(),
                          .problem = "key is missing",
                          .value = "cross",
                          .action = "add [cross], [datum_line] or a [[path]]: this job burns nothing"});
    }
}

void check_faces(const Job& job) {
    const bool marks = job.cross || job.datum_line;
    if (marks != job.faces.empty()) {
        return;
    }
    throw InputError({.file = job.file.string(),
                      .line = marks ? 0 : job.faces.front().line,
                      .problem = marks ? "key is missing" : "a face is given, but nothing is to be burnt at its points",
                      .value = "face",
                      .action = marks ? "add a [[face]] for every face that is to be burnt"
                                      : "add [cross] or [datum_line], or take it out: a [[path]] names its own face"});
}

[[noreturn]] void refuse_alignment(const Job& job, int line) {
    throw InputError({.file = job.file.string(),
                      .line = line,
                      .problem = "frame w needs the workpiece's place in c",
                      .value = "w",
                      .action = "add [alignment] with rotation and translation_mm (c_from_w)"});
}

void check_alignment(const Job& job) {
    if (job.c_from_w) {
        return;
    }
    const auto path = std::ranges::find(job.paths, PlaceFrame::w, &JobPath::frame);
    if (path != job.paths.end()) {
        refuse_alignment(job, path->line);
    }
    for (const JobFace& face : job.faces) {
        const bool line_in_w = face.datum_line && face.datum_line->frame == PlaceFrame::w;
        if (face.frame == PlaceFrame::w || line_in_w) {
            refuse_alignment(job, line_in_w ? face.datum_line->line : face.line);
        }
    }
}

JobPath read_path(TomlReader& table, std::size_t number, const Recipe* recipe) {
    JobPath path;
    path.line = table.line();
    path.name = table.text_or("name", "path " + std::to_string(number));
    path.face_deg = table.number("face_deg");
    path.frame = read_frame(table);
    if (table.has("file")) {
        path.file = beside(table.file(), table.text("file"));
        if (table.has("points_mm")) {
            table.fail("points_mm", "is given besides a file of points", "file", "give one of the two");
        }
    } else {
        path.steps = read_steps(table);
    }
    path.arc_fit = table.number_or("arc_fit", 0.0, kArcFit);
    path.settings = read_mark_settings(table, recipe);
    table.finish();
    return path;
}

std::vector<JobPath> read_free_paths(TomlReader& root, const Recipe* recipe) {
    std::vector<JobPath> paths;
    for (TomlReader& table : root.tables("path")) {
        JobPath path = read_path(table, paths.size() + 1, recipe);
        const auto same = [&path](const JobPath& other) { return other.name == path.name; };
        if (std::ranges::any_of(paths, same)) {
            table.fail("name", "appears twice", shortened(path.name), "give every path a name of its own");
        }
        paths.push_back(std::move(path));
    }
    return paths;
}

void read_files(TomlReader& root, Job& job) {
    const auto from_table = [](const JobFace& face) { return face.points.empty(); };
    if (root.has("table") || std::ranges::any_of(job.faces, from_table)) {
        job.table = beside(job.file, root.text("table"));
    }
    job.calibration = root.text("calibration");
    if (!names_stored_set(job.calibration)) {
        job.calibration = beside(job.file, job.calibration);
    }
}

Job parse_job(const std::filesystem::path& path, std::string_view text) {
    TomlDocument document(path, text, kFormat);
    TomlReader& root = document.root();
    Job job;
    job.file = path;
    job.name = root.text("name");
    std::optional<Recipe> recipe;
    if (root.has("recipe")) {
        recipe = read_recipe(beside(job.file, root.text("recipe")));
    }
    const Recipe* named = recipe ? &*recipe : nullptr;
    read_settings(root, job, named);
    if (auto table = root.table_if("alignment")) {
        job.c_from_w = Rigid<frame::C, frame::W>{table->rotation("rotation"), table->vector_mm("translation_mm")};
        table->finish();
    }
    job.faces = read_faces(root);
    job.paths = read_free_paths(root, named);
    check_faces(job);
    read_files(root, job);
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

void write_path(TomlWriter& out, const std::filesystem::path& file, const JobPath& path) {
    out.item("path");
    out.text("name", path.name);
    out.number("face_deg", path.face_deg);
    out.text("frame", name_of(path.frame));
    if (path.file.empty()) {
        std::vector<TomlWriter::Stop> stops;
        for (const PathStep& step : path.steps) {
            stops.push_back({step.via, step.to});
        }
        out.stops("points_mm", stops, 1e3);
    } else {
        out.text("file", stored_path(file, path.file));
    }
    if (path.arc_fit > 0.0) {
        out.number("arc_fit", path.arc_fit);
    }
    write_mark_settings(out, path.settings);
}

std::string rendered(const std::filesystem::path& path, const Job& job) {
    TomlWriter out(kFormat);
    out.text("name", job.name);
    if (!job.table.empty()) {
        out.text("table", stored_path(path, job.table));
    }
    out.text("calibration",
             names_stored_set(job.calibration) ? job.calibration.string() : stored_path(path, job.calibration));
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
    if (job.surface) {
        out.table("surface");
        out.text("mode", job.surface->follow ? "follow" : "check");
        out.number("window_mm", job.surface->window.si(), 1e3);
        if (job.surface->follow) {
            out.number("bound_mm", job.surface->bound.si(), 1e3);
        }
        out.number("look_speed_mm_s", job.surface->look_speed.si(), 1e3);
    }
    if (job.seating) {
        out.table("seating");
        out.numbers("expected_mm", {job.seating->expected.begin(), job.seating->expected.end()}, 1e3);
        out.number("tolerance_mm", job.seating->tolerance.si(), 1e3);
        out.number("tilt_mm", job.seating->tilt.si(), 1e3);
        out.integer("samples", job.seating->samples);
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
    for (const JobPath& free : job.paths) {
        write_path(out, path, free);
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
