// SPDX-License-Identifier: Apache-2.0
#include "host/path/free_path.hpp"

#include <cmath>

#include <fmt/format.h>

#include "host/formats/error.hpp"
#include "host/path/arc_fit.hpp"

namespace sc::host {

namespace {

constexpr double kSamePlace = 0.5e-8;        ///< metres; half a unit of the wire
constexpr double kLeastHeight = 1e-8;        ///< of an arc's middle over its chord: a unit of the wire
constexpr double kWidestArc = 100.0;         ///< metres; as the controller
constexpr double kLeastArcTolerance = 1e-7;  ///< metres; as the controller

std::string place_text(const Vec3& place) {
    return fmt::format("({:.4f}, {:.4f}, {:.4f}) mm in h", 1e3 * place.x, 1e3 * place.y, 1e3 * place.z);
}

class Maker {
public:
    Maker(const Job& job, const JobPath& path) : job_(job), path_(path) {}

    [[nodiscard]] std::vector<Piece> pieces(const std::vector<PathStep>& steps) const {
        std::vector<Piece> pieces;
        for (std::size_t i = 1; i < steps.size(); ++i) {
            pieces.push_back(piece(steps[i - 1].to, steps[i]));
        }
        return path_.arc_fit > 0.0 ? fit_arcs(pieces, path_.arc_fit * tolerance()) : pieces;
    }
    void check_tolerance(const std::vector<Piece>& pieces) const {
        const double least = kLeastArcTolerance / (1.0 - path_.arc_fit);
        for (const Piece& piece : pieces) {
            if (piece.circle && tolerance() < least * (1.0 - 1e-9)) {
                refuse(path_.line, "arcs need a tolerance", fmt::format("{:.6g} um", 1e6 * tolerance()),
                       fmt::format("use tolerance_um = {:.6g} or more", 1e6 * least));
            }
        }
    }

private:
    [[nodiscard]] double tolerance() const { return path_.settings.tolerance.si(); }

    [[noreturn]] void refuse(int line, std::string_view problem, std::string value, std::string action) const {
        const bool in_job = path_.file.empty() || line == path_.line;
        throw InputError({.file = (in_job ? job_.file : path_.file).string(),
                          .line = line,
                          .problem = fmt::format("path \"{}\": {}", path_.name, problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }

    [[nodiscard]] Piece piece(const Vec3& from, const PathStep& step) const {
        if (norm(step.to - from) < kSamePlace) {
            refuse(step.line, step.via ? "an arc ends where it begins" : "a place is repeated", place_text(step.to),
                   step.via ? "make a whole circle of two arcs" : "take it out");
        }
        if (!step.via) {
            return {from, step.to, std::nullopt, step.line};
        }
        const Vec3 chord = step.to - from;
        const Vec3 to_via = *step.via - from;
        const auto circle = circle_through(from, *step.via, step.to);
        if (!circle || norm(cross(to_via, chord)) < kLeastHeight * norm(chord)) {
            refuse(step.line, "the places of an arc lie on one line", "via " + place_text(*step.via),
                   "move via off the line, or give the end alone, as [x, y, z], for a straight piece");
        }
        if (circle->radius() > kWidestArc) {
            refuse(step.line, "an arc is too wide", fmt::format("radius {:.6g} m", circle->radius()),
                   fmt::format("keep the radius under {:.6g} m, or give points", kWidestArc));
        }
        return {from, step.to, circle, step.line};
    }

    const Job& job_;
    const JobPath& path_;
};

}  // namespace

PlannedPath free_path(const Job& job, const JobPath& path, const std::vector<PathStep>& steps) {
    const Maker maker(job, path);
    PlannedPath out;
    out.pieces = maker.pieces(steps);
    maker.check_tolerance(out.pieces);
    out.face_deg = path.face_deg;
    out.kind = PathKind::free_path;
    out.name = path.name;
    out.from = {steps.front().to};
    out.to = {steps.back().to};
    Bounds bounds = bounds_of(out.pieces.front());
    for (const Piece& piece : out.pieces) {
        bounds.take(bounds_of(piece));
    }
    out.centre = {0.5 * (bounds.low + bounds.high)};
    out.settings = path.settings;
    if (path.arc_fit > 0.0) {
        // The pieces may be that far from what was asked for: beam and place as given stay within the whole of it.
        out.settings.tolerance = Length::from_si((1.0 - path.arc_fit) * path.settings.tolerance.si());
    }
    out.source = path.file.empty() ? Source{job.file, path.line} : Source{path.file, 0};
    return out;
}

}  // namespace sc::host
