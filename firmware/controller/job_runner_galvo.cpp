// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <span>

#include "firmware/controller/job_runner.hpp"
#include "shared/math/scalar.hpp"

namespace sc {
namespace {

/// Frames that share one patch of the field correction: 0.25 mm either side at 2 m/s.
constexpr std::size_t kPatchFrames = 25;
constexpr std::size_t kX = index(Axis::x);
constexpr std::size_t kY = index(Axis::y);
constexpr std::size_t kZ = index(Axis::z);

// Inlined into the loops over a tick's frames: a call costs a fifth of it.
[[gnu::always_inline]] inline void put_frame(GalvoFrame& frame, double x, double z,
                                             const std::array<std::uint32_t, 2>& words) noexcept {
    frame.x_pm = nearest_within(x * kPmPerMetre);
    frame.z_pm = nearest_within(z * kPmPerMetre);
    frame.word_x = words[0];
    frame.word_z = words[1];
}

/// Frames of one segment under one patch; `k` is the number of the first in its tick.
template <GalvoWord kWord, bool kDepth>
void put_frames(const motion::Segment& segment, const laser::FieldPatch& patch, const motion::Place& anchor, double t,
                double k, double period, std::span<GalvoFrame> frames) noexcept {
    const trajectory::Quintic& path_x = segment.piece->axis[kX];
    [[maybe_unused]] const trajectory::Quintic& path_y = segment.piece->axis[kY];
    const trajectory::Quintic& path_z = segment.piece->axis[kZ];
    const double begin = segment.x(t);
    const double rate = period * segment.rate;
    for (GalvoFrame& frame : frames) {
        const double at = begin + k * rate;
        const double x = trajectory::value(path_x, at) - anchor[kX];
        const double z = trajectory::value(path_z, at) - anchor[kZ];
        if constexpr (kDepth) {
            put_frame(frame, x, z, patch.words_at<kWord>({x, z, trajectory::value(path_y, at) - anchor[kY]}));
        } else {
            put_frame(frame, x, z, patch.words_at<kWord>(x, z));
        }
        k = k + 1.0;
    }
}

}  // namespace

void JobRunner::galvo_still(ServoOutputs& out) const noexcept {
    const laser::FieldPatch patch = field_patch({field_x_, field_depth_, field_z_, 0.0});
    put_frame(out.galvo[0], field_x_, field_z_, patch.words({field_x_, field_z_, field_depth_}));
    for (std::size_t k = 1; k < kGalvoFramesPerTick; ++k) {
        out.galvo[k] = out.galvo[0];
    }
}

void JobRunner::galvo_jump(double t, ServoOutputs& out) noexcept {
    const auto field_at = [&](std::size_t k) noexcept {
        return move_.at(t + exact_double(static_cast<std::int64_t>(k) * machine_.galvo_period_ns) * 1e-9);
    };
    laser::FieldPatch patch;
    for (std::size_t k = 0; k < kGalvoFramesPerTick; ++k) {
        if (k % kPatchFrames == 0) {
            patch = field_patch(field_at(k + kPatchFrames / 2));
        }
        const motion::Place field = field_at(k);
        put_frame(out.galvo[k], field[kX], field[kZ], patch.words({field[kX], field[kZ], field[kY]}));
        field_x_ = field[kX];
        field_z_ = field[kZ];
        field_depth_ = field[kY];
    }
}

void JobRunner::galvo_path(double t, ServoOutputs& out) noexcept {
    const double period = exact_double(machine_.galvo_period_ns) * 1e-9;
    const motion::Place anchor{metres(path_.anchor_x), metres(path_.anchor_y), metres(path_.anchor_z), 0.0};
    const bool curved = field_.curved();
    const bool wide = machine_.galvo.word == GalvoWord::bits18;
    const auto put = curved ? (wide ? put_frames<GalvoWord::bits18, true> : put_frames<GalvoWord::bits16, true>)
                            : (wide ? put_frames<GalvoWord::bits18, false> : put_frames<GalvoWord::bits16, false>);
    double k = 0.0;
    std::size_t frame = 0;
    std::size_t patch_end = 0;
    laser::FieldPatch patch;
    motion::Cursor ahead = cursor_;
    while (frame < kGalvoFramesPerTick) {
        if (frame == patch_end) {
            motion::Place at = anchor;
            if (curved) {
                const double middle = t + (k + 0.5 * static_cast<double>(kPatchFrames)) * period;
                const motion::Segment there = motion_.segment(middle, ahead);
                at = there.piece->place(there.x(middle));
            }
            patch = field_patch({at[kX] - anchor[kX], at[kY] - anchor[kY], at[kZ] - anchor[kZ], 0.0});
            patch_end += curved ? kPatchFrames : kGalvoFramesPerTick;
        }
        const motion::Segment segment = motion_.segment(t + k * period, cursor_);
        // Frames before the segment's end, at least this one.
        const double left = clamped((segment.end - t) / period - k, 1.0, static_cast<double>(kGalvoFramesPerTick));
        const auto whole = static_cast<std::uint32_t>(left);
        const std::size_t count = whole + (left > static_cast<double>(whole) ? 1U : 0U);
        const std::size_t last = std::min<std::size_t>(frame + count, patch_end);
        put(segment, patch, anchor, t, k, period, std::span(out.galvo).subspan(frame, last - frame));
        k = k + static_cast<double>(static_cast<std::uint32_t>(last - frame));
        frame = last;
        const motion::Place at = segment.piece->place(segment.x(t + (k - 1.0) * period));
        field_x_ = at[kX] - anchor[kX];
        field_z_ = at[kZ] - anchor[kZ];
        field_depth_ = at[kY] - anchor[kY];
    }
}

}  // namespace sc
