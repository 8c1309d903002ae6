// SPDX-License-Identifier: Apache-2.0
#include "shared/path/job_hash.hpp"

#include "shared/path/block.hpp"

namespace sc {
namespace {

std::uint32_t word(std::int32_t value) noexcept { return static_cast<std::uint32_t>(value); }

struct Words {
    Fnv1a64& hash;
    void operator()(const PathPoint& p) const noexcept {
        hash.update_word(block_tag::kPoints).update_word(word(p.x)).update_word(word(p.y)).update_word(word(p.z));
    }
    void operator()(const PathArc& a) const noexcept {
        hash.update_word(block_tag::kPathArc).update_word(word(a.via.x)).update_word(word(a.via.y));
        hash.update_word(word(a.via.z)).update_word(word(a.to.x)).update_word(word(a.to.y)).update_word(word(a.to.z));
    }
    void operator()(const PathBegin& b) const noexcept {
        const auto actuator = static_cast<std::uint32_t>(b.actuator);
        hash.update_word(block_tag::kPathBegin).update_word(b.path).update_word(actuator + 256U * b.pass);
        hash.update_word(b.speed_um_s).update_word(b.pitch_nm).update_word(b.energy_nj).update_word(b.tolerance_nm);
        hash.update_word(word(b.anchor_x)).update_word(word(b.anchor_y)).update_word(word(b.anchor_z));
    }
    void operator()(const PathLight& light) const noexcept {
        hash.update_word(block_tag::kPathLight).update_word(light.on ? 1 : 0);
    }
    void operator()(const StageCurve& curve) const noexcept {
        hash.update_word(block_tag::kStageCurve).update_word(curve.spacing_um);
    }
    void operator()(const StageKnot& k) const noexcept {
        hash.update_word(block_tag::kStageKnot).update_word(word(k.x)).update_word(word(k.y)).update_word(word(k.z));
    }
    void operator()(const Look& l) const noexcept {
        hash.update_word(block_tag::kLook).update_word(l.speed_um_s);
        hash.update_word(word(l.x)).update_word(word(l.y)).update_word(word(l.z));
    }
    void operator()(const PathEnd& /*end*/) const noexcept { hash.update_word(block_tag::kPathEnd); }
    void operator()(const Turn& turn) const noexcept { hash.update_word(block_tag::kTurn).update_word(word(turn.c)); }
    void operator()(const JobEnd& /*end*/) const noexcept { hash.update_word(block_tag::kJobEnd); }
};

}  // namespace

void JobHasher::add(const Item& item) noexcept {
    const Words words{hash_};
    if (const auto* point = std::get_if<PathPoint>(&item)) {
        words(*point);
    } else if (const auto* begin = std::get_if<PathBegin>(&item)) {
        words(*begin);
    } else if (const auto* end = std::get_if<PathEnd>(&item)) {
        words(*end);
    } else if (const auto* turn = std::get_if<Turn>(&item)) {
        words(*turn);
    } else if (const auto* job_end = std::get_if<JobEnd>(&item)) {
        words(*job_end);
    } else if (const auto* arc = std::get_if<PathArc>(&item)) {
        words(*arc);
    } else if (const auto* light = std::get_if<PathLight>(&item)) {
        words(*light);
    } else if (const auto* curve = std::get_if<StageCurve>(&item)) {
        words(*curve);
    } else if (const auto* knot = std::get_if<StageKnot>(&item)) {
        words(*knot);
    } else if (const auto* look = std::get_if<Look>(&item)) {
        words(*look);
    }
}

std::uint64_t job_hash(std::span<const Item> items) noexcept {
    JobHasher hasher;
    for (const Item& item : items) {
        hasher.add(item);
    }
    return hasher.value();
}

}  // namespace sc
