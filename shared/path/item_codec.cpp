// SPDX-License-Identifier: Apache-2.0
#include "shared/path/item_codec.hpp"

#include "shared/path/block.hpp"

namespace sc {
namespace {

void put_path_begin(ByteWriter& out, const PathBegin& begin) noexcept {
    out.put(block_tag::kPathBegin);
    out.put(begin.path);
    out.put(static_cast<std::uint8_t>(begin.actuator));
    out.put(begin.pass);
    out.put(begin.speed_um_s);
    out.put(begin.pitch_nm);
    out.put(begin.energy_nj);
    out.put(begin.tolerance_nm);
    out.put(begin.anchor_x);
    out.put(begin.anchor_y);
    out.put(begin.anchor_z);
}

void put_place(ByteWriter& out, const PathPoint& place) noexcept {
    out.put(place.x);
    out.put(place.y);
    out.put(place.z);
}

}  // namespace

void put_item(ByteWriter& out, const Item& item) noexcept {
    if (const auto* point = std::get_if<PathPoint>(&item)) {
        out.put(block_tag::kPoints);
        put_place(out, *point);
    } else if (const auto* begin = std::get_if<PathBegin>(&item)) {
        put_path_begin(out, *begin);
    } else if (std::holds_alternative<PathEnd>(item)) {
        out.put(block_tag::kPathEnd);
    } else if (const auto* turn = std::get_if<Turn>(&item)) {
        out.put(block_tag::kTurn);
        out.put(turn->c);
    } else if (std::holds_alternative<JobEnd>(item)) {
        out.put(block_tag::kJobEnd);
    } else if (const auto* arc = std::get_if<PathArc>(&item)) {
        out.put(block_tag::kPathArc);
        put_place(out, arc->via);
        put_place(out, arc->to);
    } else if (const auto* light = std::get_if<PathLight>(&item)) {
        out.put(block_tag::kPathLight);
        out.put(static_cast<std::uint8_t>(light->on ? 1 : 0));
    } else if (const auto* curve = std::get_if<StageCurve>(&item)) {
        out.put(block_tag::kStageCurve);
        out.put(curve->spacing_um);
    } else if (const auto* knot = std::get_if<StageKnot>(&item)) {
        out.put(block_tag::kStageKnot);
        put_place(out, {knot->x, knot->y, knot->z});
    } else if (const auto* look = std::get_if<Look>(&item)) {
        out.put(block_tag::kLook);
        out.put(look->speed_um_s);
        put_place(out, {look->x, look->y, look->z});
    }
}

}  // namespace sc
