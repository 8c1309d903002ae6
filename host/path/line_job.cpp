// SPDX-License-Identifier: Apache-2.0
#include "host/path/line_job.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <tuple>

namespace sc::host {

LineJob line_job(std::span<const LineToBurn> lines, const BeamReach& reach, const MarkSettings& settings) {
    LineJob out;
    std::map<std::string, int> numbers;
    for (const LineToBurn& line : lines) {
        SplitLine split = reach.split(line.places, line.closed, line.normal);
        for (ReachedPiece& piece : split.reached) {
            out.burnt_length += piece.length;
            out.burnt.push_back({line.id + " " + std::to_string(++numbers[line.id]), line.id, std::move(piece)});
        }
        for (const MissedPiece& piece : split.missed) {
            out.missed_length += piece.length;
            out.missed.push_back({line.id, piece});
        }
    }
    const auto rank = [&](double face) {
        return std::ranges::find(reach.options().faces, face) - reach.options().faces.begin();
    };
    std::ranges::sort(out.burnt, [&](const BurntPiece& a, const BurntPiece& b) {
        return std::tuple(rank(a.piece.face_deg), -a.piece.length, std::string_view(a.name)) <
               std::tuple(rank(b.piece.face_deg), -b.piece.length, std::string_view(b.name));
    });
    std::ranges::sort(out.missed, [](const NotBurnt& a, const NotBurnt& b) {
        const Vec3& p = a.piece.from;
        const Vec3& q = b.piece.from;
        return std::tuple(-a.piece.length, p.x, p.y, p.z) < std::tuple(-b.piece.length, q.x, q.y, q.z);
    });
    for (const BurntPiece& burnt : out.burnt) {
        JobPath path;
        path.name = burnt.name;
        path.face_deg = burnt.piece.face_deg;
        path.frame = PlaceFrame::c;
        path.settings = settings;
        for (const SurfacePlace& place : burnt.piece.places) {
            path.steps.push_back({.line = 0, .via = std::nullopt, .to = place.place});
        }
        out.paths.push_back(std::move(path));
    }
    return out;
}

}  // namespace sc::host
