// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/inspection_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <nlohmann/json.hpp>

#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr double kMm = 1e3;
constexpr std::array<const char*, 3> kAxes{"X", "Y", "Z"};
constexpr std::array<const char*, 6> kMotions{"x", "y", "z", "rx", "ry", "rz"};

double degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

/// Rounded, so that a file does not pretend to digits that nobody measured: 1 nm.
double mm(double metres) { return std::round(kMm * metres * 1e6) / 1e6; }

nlohmann::ordered_json to_json(const Vec3& v) { return nlohmann::ordered_json::array({mm(v.x), mm(v.y), mm(v.z)}); }

template <class To, class From>
nlohmann::ordered_json to_json(const Rigid<To, From>& x) {
    nlohmann::ordered_json rotation = nlohmann::ordered_json::array();
    for (const Vec3& row : x.rotation.row) {
        rotation.push_back({row.x, row.y, row.z});
    }
    return {{"rotation", rotation}, {"translation_mm", to_json(x.translation)}};
}

nlohmann::ordered_json to_json(const FaceAllowance& face) {
    nlohmann::ordered_json worst = nlohmann::ordered_json::array();
    for (const WorstPlace& place : face.worst) {
        worst.push_back({{"place_mm", to_json(place.place)}, {"allowance_mm", mm(place.allowance)}});
    }
    return {{"id", face.id},
            {"asked_mm", mm(face.least_asked)},
            {"points", face.count},
            {"min_mm", mm(face.least)},
            {"mean_mm", mm(face.mean)},
            {"max_mm", mm(face.most)},
            {"sigma_mm", mm(face.sigma)},
            {"margin_mm", mm(face.margin())},
            {"enough", face.enough()},
            {"histogram",
             {{"low_mm", mm(face.histogram_low)}, {"bin_mm", mm(face.histogram_width)}, {"counts", face.histogram}}},
            {"worst", worst}};
}

nlohmann::ordered_json to_json(const AllowanceReport& report) {
    nlohmann::ordered_json faces = nlohmann::ordered_json::array();
    for (const FaceAllowance& face : report.faces) {
        faces.push_back(to_json(face));
    }
    nlohmann::ordered_json sides = nlohmann::ordered_json::object();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t k = 0; k < 2; ++k) {
            const Side& side = report.sides[axis][k];
            sides[std::string(k == 0 ? "+" : "-") + kAxes[axis]] = {
                {"points", side.count}, {"min_mm", mm(side.least)}, {"mean_mm", mm(side.mean)}};
        }
    }
    return {
        {"enough", report.enough()}, {"least_margin_mm", mm(report.least_margin)}, {"faces", faces}, {"sides", sides}};
}

nlohmann::ordered_json to_json(const Inspection& inspection, const Borrowing& b) {
    nlohmann::ordered_json active = nlohmann::ordered_json::array();
    for (const ActivePoint& a : b.active) {
        active.push_back({{"face", inspection.plan.groups[a.group].id},
                          {"side", a.upper ? "most" : "least"},
                          {"multiplier", a.multiplier},
                          {"margin_mm", mm(a.margin)},
                          {"place_mm", to_json(a.place)},
                          {"direction", {a.direction.x, a.direction.y, a.direction.z}}});
    }
    nlohmann::ordered_json bounds = nlohmann::ordered_json::array();
    for (const ActiveBound& bound : b.bounds) {
        bounds.push_back(
            {{"motion", kMotions[bound.motion]}, {"side", bound.upper ? "+" : "-"}, {"multiplier", bound.multiplier}});
    }
    nlohmann::ordered_json fight = nlohmann::ordered_json::array();
    for (const Conflict& c : conflicts(inspection)) {
        fight.push_back({{"face", c.id}, {"share", c.share}, {"asked_mm", mm(c.asked)}, {"best_mm", mm(c.best)}});
    }
    return {{"shift_mm", {mm(b.along[0]), mm(b.along[1]), mm(b.along[2])}},
            {"turn_deg", {degrees(b.along[3]), degrees(b.along[4]), degrees(b.along[5])}},
            {"motion", to_json(b.motion)},
            {"w_from_c", to_json(b.motion * inspection.w_from_c)},
            {"margin_before_mm", mm(b.margin_before)},
            {"margin_mm", mm(b.margin)},
            {"variance_before_mm2", b.variance_before * kMm * kMm},
            {"variance_mm2", b.variance * kMm * kMm},
            {"active", active},
            {"bounds", bounds},
            {"stopped_by", fight},
            {"kkt_residual", b.kkt_residual},
            {"rounds", b.rounds}};
}

nlohmann::ordered_json to_json(const DatumLine& line) {
    nlohmann::ordered_json runs = nlohmann::ordered_json::array();
    for (const LineRun& run : line.cut.runs) {
        runs.push_back({{"closed", run.closed}, {"length_mm", mm(run.length)}, {"places", run.places.size()}});
    }
    nlohmann::ordered_json gaps = nlohmann::ordered_json::array();
    for (const LineGap& gap : line.cut.gaps) {
        gaps.push_back({{"from_mm", to_json(gap.from)}, {"to_mm", to_json(gap.to)}, {"length_mm", mm(gap.length)}});
    }
    return {{"id", line.id},
            {"length_mm", mm(line.cut.length)},
            {"cad_mm", mm(line.cad_length)},
            {"points", line.cut.points},
            {"runs", runs},
            {"gaps", gaps}};
}

template <class... Values>
void add(std::string& out, const char* format, Values... values) {
    std::array<char, 256> line{};
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg,clang-diagnostic-format-nonliteral): formats are literals, below
    const int size = std::snprintf(line.data(), line.size(), format, values...);
    out.append(line.data(), static_cast<std::size_t>(std::clamp(size, 0, 255)));
}

void add_faces(std::string& out, const AllowanceReport& before, const AllowanceReport* after) {
    add(out, "%-28s %7s %8s %8s %8s %8s", "face, mm", "asked", "min", "mean", "max", "points");
    out += after != nullptr ? "  | after:  min     mean\n" : "\n";
    for (std::size_t i = 0; i < before.faces.size(); ++i) {
        const FaceAllowance& face = before.faces[i];
        add(out, "%-28.28s %7.3f %8.3f %8.3f %8.3f %8zu", face.id.c_str(), kMm * face.least_asked, kMm * face.least,
            kMm * face.mean, kMm * face.most, face.count);
        const FaceAllowance& last = after != nullptr ? after->faces[i] : face;
        if (after != nullptr) {
            add(out, "  | %9.3f %8.3f", kMm * last.least, kMm * last.mean);
        }
        out += face.count == 0 ? "  NOT SEEN\n" : (last.enough() ? "  ok\n" : "  LACKING\n");
    }
}

void add_sides(std::string& out, const AllowanceReport& before, const AllowanceReport* after) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& sides = before.sides[axis];
        if (sides[0].count + sides[1].count == 0) {
            continue;
        }
        add(out, "%s  mean over sides towards + %8.3f, towards - %8.3f mm", kAxes[axis], kMm * sides[0].mean,
            kMm * sides[1].mean);
        if (after != nullptr) {
            add(out, "; after borrowing %8.3f, %8.3f", kMm * after->sides[axis][0].mean,
                kMm * after->sides[axis][1].mean);
        }
        out += "\n";
    }
}

void add_borrowing(std::string& out, const Inspection& inspection, const Borrowing& b) {
    add(out, "\nborrowing: shift %.4f %.4f %.4f mm, turn %.5f %.5f %.5f deg\n", kMm * b.along[0], kMm * b.along[1],
        kMm * b.along[2], degrees(b.along[3]), degrees(b.along[4]), degrees(b.along[5]));
    add(out, "smallest margin %.4f -> %.4f mm; variance in the faces %.5f -> %.5f mm2\n", kMm * b.margin_before,
        kMm * b.margin, b.variance_before * kMm * kMm, b.variance * kMm * kMm);
    add(out, "proved: %zu points and %zu bounds stop it, KKT residual %.1e\n", b.active.size(), b.bounds.size(),
        b.kkt_residual);
    for (const Conflict& c : conflicts(inspection)) {
        add(out, "  stopped by %-24.24s share %.3f: asks %.3f, gets %.3f mm at best\n", c.id.c_str(), c.share,
            kMm * c.asked, kMm * c.best);
    }
    for (const ActiveBound& bound : b.bounds) {
        add(out, "  stopped by the bound of motion %s\n", kMotions[bound.motion]);
    }
    if (b.margin < 0.0) {
        add(out, "INFEASIBLE: no placement within the bounds gives every face what it asks; %.3f mm is lacking\n",
            -kMm * b.margin);
    }
}

}  // namespace

std::string inspection_text(const Inspection& i) {
    std::string out;
    for (const std::string& note : i.notes) {
        out += "note: " + note + "\n";
    }
    add(out, "aligned by %s; %zu points, %zu used, %zu rejected, spread %.4f mm, %.0f %% of the CAD surface seen\n",
        std::string(name_of(i.aligned_by)).c_str(), i.points, i.fit.used, i.fit.rejected, kMm * i.fit.sigma,
        100.0 * i.coverage);
    for (const ReferenceUse& r : i.references) {
        add(out, "  reference %-8.40s %6zu points, off by %.4f mm\n", r.id.c_str(), r.points, kMm * r.offset);
    }
    const AllowanceReport* after = i.after ? &*i.after : nullptr;
    out += "\n";
    add_faces(out, i.before, after);
    add(out, "left out: %zu at edges and rims, %zu on walls across, %zu outliers\n", i.over.left_out.at_edges,
        i.over.left_out.other_way, i.over.left_out.outliers);
    if (i.as_cast.count > 0) {
        add(out, "as cast: %zu points, mean %.4f, sigma %.4f, from %.3f to %.3f mm\n", i.as_cast.count,
            kMm * i.as_cast.mean, kMm * i.as_cast.sigma, kMm * i.as_cast.least, kMm * i.as_cast.most);
    }
    add_sides(out, i.before, after);
    const AllowanceReport& last = after != nullptr ? *after : i.before;
    if (const FaceAllowance* worst = last.worst()) {
        out += "worst places (mm):";
        for (const WorstPlace& place : worst->worst) {
            add(out, " %.3f at (%.2f %.2f %.2f)", kMm * place.allowance, kMm * place.place.x, kMm * place.place.y,
                kMm * place.place.z);
        }
        out += " on " + worst->id + "\n";
    }
    if (i.borrowing) {
        add_borrowing(out, i, *i.borrowing);
    }
    for (const DatumLine& line : i.lines) {
        add(out, "datum %s: a line of %.1f mm in %zu pieces, %zu gaps%s\n", line.id.c_str(), kMm * line.cut.length,
            line.cut.runs.size(), line.cut.gaps.size(), line.cut.gaps.empty() ? "" : ":");
        for (const LineGap& gap : line.cut.gaps) {
            add(out, "  %.1f mm from (%.2f %.2f %.2f) to (%.2f %.2f %.2f)\n", kMm * gap.length, kMm * gap.from.x,
                kMm * gap.from.y, kMm * gap.from.z, kMm * gap.to.x, kMm * gap.to.y, kMm * gap.to.z);
        }
    }
    if (i.what_if) {
        out += "\nwhat if, at the motion that was asked about:\n";
        add_faces(out, *i.what_if, nullptr);
    }
    out += last.enough() ? "\nverdict: metal everywhere\n" : "\nverdict: NOT ENOUGH METAL\n";
    return out;
}

nlohmann::ordered_json uncertainty_json(const Uncertainty& uncertainty) {
    const auto list = [](const std::vector<UncertaintySource>& sources) {
        nlohmann::ordered_json out{{"expanded_mm", mm(expanded(sources))},
                                   {"sources", nlohmann::ordered_json::array()}};
        for (const UncertaintySource& source : sources) {
            out["sources"].push_back({{"name", source.name}, {"sigma_mm", mm(source.sigma)}, {"from", source.from}});
        }
        return out;
    };
    return {{"allowance", list(uncertainty.allowance)}, {"lines", list(uncertainty.lines)}};
}

nlohmann::ordered_json inspection_json(const Inspection& i) {
    nlohmann::ordered_json references = nlohmann::ordered_json::array();
    for (const ReferenceUse& r : i.references) {
        references.push_back({{"id", r.id}, {"points", r.points}, {"offset_mm", mm(r.offset)}});
    }
    nlohmann::ordered_json seconds = nlohmann::ordered_json::object();
    for (const auto& [name, value] : i.seconds) {
        seconds[name] = value;
    }
    nlohmann::ordered_json out{{"enough", i.after ? i.after->enough() : i.before.enough()},
                               {"notes", i.notes},
                               {"points", i.points},
                               {"cad", {{"closed", i.closed}, {"shells", i.shells}, {"faces", i.map.faces.size()}}},
                               {"alignment",
                                {{"by", name_of(i.aligned_by)},
                                 {"w_from_c", to_json(i.w_from_c)},
                                 {"used", i.fit.used},
                                 {"rejected", i.fit.rejected},
                                 {"sigma_mm", mm(i.fit.sigma)},
                                 {"stiffness", i.fit.stiffness},
                                 {"coverage", i.coverage},
                                 {"references", references}}},
                               {"left_out",
                                {{"at_edges", i.over.left_out.at_edges},
                                 {"across", i.over.left_out.other_way},
                                 {"outliers", i.over.left_out.outliers}}},
                               {"as_cast",
                                {{"points", i.as_cast.count},
                                 {"mean_mm", mm(i.as_cast.mean)},
                                 {"sigma_mm", mm(i.as_cast.sigma)},
                                 {"low_mm", mm(i.as_cast.least)},
                                 {"high_mm", mm(i.as_cast.most)}}},
                               {"before", to_json(i.before)}};
    out["after"] = i.after ? to_json(*i.after) : nlohmann::ordered_json();
    out["borrowing"] = i.borrowing ? to_json(i, *i.borrowing) : nlohmann::ordered_json();
    out["what_if"] = i.what_if ? to_json(*i.what_if) : nlohmann::ordered_json();
    out["lines"] = nlohmann::ordered_json::array();
    for (const DatumLine& line : i.lines) {
        out["lines"].push_back(to_json(line));
    }
    out["seconds"] = seconds;
    return out;
}

}  // namespace sc::host
