// SPDX-License-Identifier: Apache-2.0
#include "host/cli/inspect_lines.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/cli/number_text.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/formats/dxf.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"

namespace sc::host::cli {

namespace {

/// As the datum lines of the example.
MarkSettings settings_of_lines() {
    using namespace literals;
    MarkSettings settings;
    settings.actuator = Actuator::axes;
    settings.speed = 60.0_mm_s;
    settings.pitch = 20_um;
    settings.energy = Energy::from_si(300e-6);
    return settings;
}

void write_table(const std::filesystem::path& file, const LineJob& job, const BeamReach& reach) {
    std::string out =
        "# Lines to be burnt, millimetres: in c with the outward normal, and in h with the face before the laser "
        "(h_y is the depth).\nname,face_deg,s,x,y,z,nx,ny,nz,h_x,h_y,h_z,incidence_deg,sigma_um\n";
    for (const BurntPiece& burnt : job.burnt) {
        std::size_t face = 0;
        while (reach.options().faces[face] != burnt.piece.face_deg) {
            ++face;
        }
        double s = 0.0;
        const Vec3* last = nullptr;
        for (const SurfacePlace& at : burnt.piece.places) {
            s += last == nullptr ? 0.0 : norm(at.place - *last);
            last = &at.place;
            const Vec3 h = reach.in_h(at.place, face);
            out += fmt::format(
                "{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.5f},{:.5f},{:.5f},{:.4f},{:.4f},{:.4f},{:.2f},{:.1f}\n",
                burnt.name, number_text(burnt.piece.face_deg), 1e3 * s, 1e3 * at.place.x, 1e3 * at.place.y,
                1e3 * at.place.z, at.normal.x, at.normal.y, at.normal.z, 1e3 * h.x, 1e3 * h.y, 1e3 * h.z,
                reach.incidence_deg(at, face), 1e6 * at.sigma);
        }
    }
    write_text_file(file, out);
}

std::vector<LineToBurn> in_c(const Inspection& inspection) {
    const auto c_from_w = inspection.final_w_from_c().inverse();
    std::vector<LineToBurn> out;
    for (const DatumLine& line : inspection.lines) {
        for (const LineRun& run : line.cut.runs) {
            LineToBurn burn{
                .id = line.id, .places = {}, .closed = run.closed, .normal = c_from_w.rotation * line.plane.normal};
            for (const LinePlace& at : run.places) {
                burn.places.push_back(
                    {(c_from_w * Point<frame::W>{at.place}).v, c_from_w.rotation * at.normal, at.sigma});
            }
            out.push_back(std::move(burn));
        }
    }
    return out;
}

}  // namespace

std::optional<LineJob> write_lines(const Inspection& inspection, std::span<const Vec3> scan, const LineFiles& files) {
    std::error_code failed;
    std::filesystem::create_directories(files.folder, failed);
    if (failed) {
        throw InputError({.file = files.folder.string(),
                          .problem = "the folder for the lines cannot be made",
                          .value = failed.message(),
                          .action = "name another with --lines"});
    }
    std::vector<DxfLine> drawn;
    for (const DatumLine& line : inspection.lines) {
        for (const LineRun& run : line.cut.runs) {
            DxfLine dxf{.layer = "datum_" + line.id, .places = {}, .closed = run.closed};
            for (const LinePlace& at : run.places) {
                dxf.places.push_back(at.place);
            }
            drawn.push_back(std::move(dxf));
        }
    }
    write_dxf(files.folder / "lines.dxf", drawn);
    if (!files.calibration) {
        return std::nullopt;
    }
    const CalibrationSet calibration = read_calibration(*files.calibration);
    ReachOptions options;
    options.faces = files.faces.empty() ? options.faces : files.faces;
    options.incidence_deg = files.incidence_deg;
    const MarkSettings settings = files.settings.value_or(settings_of_lines());
    options.edge += 0.5 * settings.width.si();
    const std::vector<LineToBurn> to_burn = in_c(inspection);
    if (files.plain) {
        options.edge = options.unseen_rim = 0.0;
        options.off_plane = std::numeric_limits<double>::infinity();
    }
    for (const LineToBurn& line : files.plain ? std::span<const LineToBurn>() : std::span(to_burn)) {
        for (const double face : faces_along(calibration, line.normal)) {
            options.faces.push_back(face);
        }
    }
    std::ranges::sort(options.faces);
    options.faces.erase(std::ranges::unique(options.faces).begin(), options.faces.end());
    const BeamReach reach(calibration, reference_machine(), scan, options);
    LineJob lines = line_job(to_burn, reach, settings);
    if (lines.paths.empty()) {
        const std::string why = lines.missed.empty() ? "" : std::string(name_of(lines.missed.front().piece.why));
        throw InputError({.file = files.calibration->string(),
                          .problem = "the beam reaches no datum line from any of the faces",
                          .value = why,
                          .action = "check h_from_c and where the casting stands, or name other faces with --faces"});
    }
    write_table(files.folder / "lines.csv", lines, reach);
    Job job;
    job.name = "datum lines";
    job.calibration = std::filesystem::absolute(*files.calibration);
    job.c_from_w = inspection.final_w_from_c().inverse();
    job.paths = lines.paths;
    write_job(files.folder / "job.toml", job);
    return lines;
}

nlohmann::ordered_json line_job_json(const LineJob& job) {
    const auto mm = [](double metres) { return std::round(1e7 * metres) / 1e4; };
    const auto place = [&](const Vec3& v) { return nlohmann::ordered_json::array({mm(v.x), mm(v.y), mm(v.z)}); };
    nlohmann::ordered_json burnt = nlohmann::ordered_json::array();
    for (const BurntPiece& b : job.burnt) {
        burnt.push_back({{"name", b.name},
                         {"datum", b.id},
                         {"face_deg", b.piece.face_deg},
                         {"length_mm", mm(b.piece.length)},
                         {"places", b.piece.places.size()},
                         {"worst_incidence_deg", b.piece.worst_incidence_deg}});
    }
    nlohmann::ordered_json missed = nlohmann::ordered_json::array();
    for (const NotBurnt& m : job.missed) {
        missed.push_back({{"datum", m.id},
                          {"from_mm", place(m.piece.from)},
                          {"to_mm", place(m.piece.to)},
                          {"length_mm", mm(m.piece.length)},
                          {"why", name_of(m.piece.why)}});
    }
    return {
        {"burnt_mm", mm(job.burnt_length)}, {"missed_mm", mm(job.missed_length)}, {"burnt", burnt}, {"missed", missed}};
}

std::string line_job_text(const LineJob& job, const LineFiles& files) {
    std::string out =
        fmt::format("lines: {:.1f} mm in {} paths, written to {}; {:.1f} mm not reached\n", 1e3 * job.burnt_length,
                    job.burnt.size(), (files.folder / "job.toml").string(), 1e3 * job.missed_length);
    for (std::size_t i = 0; i < job.missed.size() && i < 8; ++i) {
        const NotBurnt& m = job.missed[i];
        out += fmt::format("  datum {}: {:.1f} mm: {}\n", m.id, 1e3 * m.piece.length, name_of(m.piece.why));
    }
    return out;
}

}  // namespace sc::host::cli
