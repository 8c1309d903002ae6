// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <span>

#include "firmware/controller/job_runner.hpp"
#include "firmware/laser/frame_polynomial.hpp"
#include "shared/math/scalar.hpp"

namespace sc {
namespace {

/// Frames that share one patch of the field correction: 0.25 mm either side at 2 m/s.
constexpr std::size_t kPatchFrames = 25;
constexpr std::size_t kMostPatchFrames = 32;
constexpr std::size_t kFewestPatchFrames = 14;

/// Frames of the patch that begins where the path's segment has `left` more. It ends where the segment does if that is
/// near, since each pair of both costs its polynomials.
constexpr std::size_t patch_frames(std::size_t left) noexcept {
    if (left < kFewestPatchFrames) {
        return kPatchFrames;
    }
    if (left <= kMostPatchFrames) {
        return left;
    }
    return left < 2 * kPatchFrames ? (left + 1) / 2 : kPatchFrames;
}
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

/// A piece of a straight run, or of two that overlap.
bool is_cubic(const trajectory::Piece& piece) noexcept {
    double rest = 0.0;
    for (const std::size_t i : {kX, kY, kZ}) {
        rest = rest + (absolute(piece.axis[i][4]) + absolute(piece.axis[i][5]));
    }
    return rest == 0.0;
}

/// Frames of one segment under one patch, from path time t on: the words' counts are polynomials too.
template <GalvoWord kWord, std::size_t kDegree>
void put_frames(const motion::Segment& segment, const laser::FieldPatch& patch, const motion::Place& anchor, double t,
                double period, std::span<GalvoFrame> frames) noexcept {
    using Polynomial = laser::FramePolynomial<kDegree>;
    const double begin = segment.x(t);
    const double step = period * segment.rate;
    const auto& axis = segment.piece->axis;
    Polynomial place_x = laser::over_frames<kDegree>(axis[kX], begin, step);
    Polynomial place_z = laser::over_frames<kDegree>(axis[kZ], begin, step);
    Polynomial depth = laser::over_frames<kDegree>(axis[kY], begin, step);
    place_x[0] -= anchor[kX];
    place_z[0] -= anchor[kZ];
    depth[0] -= anchor[kY];
    const auto counts = [&](std::size_t mirror) noexcept {
        const std::array<double, 3>& m = patch.m[mirror];
        Polynomial sum;
        for (std::size_t n = 0; n <= kDegree; ++n) {
            sum[n] = m[0] * place_x[n] + m[1] * place_z[n] + m[2] * depth[n];
        }
        sum[0] += patch.offset[mirror];
        return sum;
    };
    // Two loops: the differences of two polynomials are what a core's registers hold.
    laser::FrameValues<kDegree> count_x(counts(0));
    laser::FrameValues<kDegree> count_z(counts(1));
    for (GalvoFrame& frame : frames) {
        const auto words =
            patch.format.clamped_words<kWord>(nearest32_within(count_x.value()), nearest32_within(count_z.value()));
        frame.word_x = words[0];
        frame.word_z = words[1];
        count_x.next();
        count_z.next();
    }
    for (std::size_t n = 0; n <= kDegree; ++n) {
        place_x[n] *= kPmPerMetre;
        place_z[n] *= kPmPerMetre;
    }
    laser::FrameValues<kDegree> x(place_x);
    laser::FrameValues<kDegree> z(place_z);
    for (GalvoFrame& frame : frames) {
        frame.x_pm = nearest_within(x.value());
        frame.z_pm = nearest_within(z.value());
        x.next();
        z.next();
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
    const bool wide = machine_.galvo.word == GalvoWord::bits18;
    const auto put = wide ? put_frames<GalvoWord::bits18, 5> : put_frames<GalvoWord::bits16, 5>;
    const auto put_cubic = wide ? put_frames<GalvoWord::bits18, 3> : put_frames<GalvoWord::bits16, 3>;
    const auto time_of = [&](std::size_t frame) noexcept {
        return t + exact_double(static_cast<std::int64_t>(frame)) * period;
    };
    motion::Cursor ahead = cursor_;
    laser::FieldPatch patch = field_.flat();
    std::size_t patch_end = field_.curved() ? 0 : kGalvoFramesPerTick;
    std::size_t frame = 0;
    while (frame < kGalvoFramesPerTick) {
        const double now = time_of(frame);
        const motion::Segment segment = motion_.segment(now, cursor_);
        // Frames before the segment's end, at least this one.
        const double left = clamped((segment.end - now) / period, 1.0, static_cast<double>(kGalvoFramesPerTick));
        const auto whole = static_cast<std::uint32_t>(left);
        const std::size_t count = whole + (left > static_cast<double>(whole) ? 1U : 0U);
        if (frame == patch_end) {
            const std::size_t frames = patch_frames(count);
            const double middle = now + 0.5 * exact_double(static_cast<std::int64_t>(frames)) * period;
            const motion::Segment there = middle < segment.end ? segment : motion_.segment(middle, ahead);
            const motion::Place at = there.piece->place(there.x(middle));
            patch = field_patch({at[kX] - anchor[kX], at[kY] - anchor[kY], at[kZ] - anchor[kZ], 0.0});
            patch_end += frames;
        }
        const std::size_t last = std::min({frame + count, patch_end, kGalvoFramesPerTick});
        (is_cubic(*segment.piece) ? put_cubic : put)(segment, patch, anchor, now, period,
                                                     std::span(out.galvo).subspan(frame, last - frame));
        frame = last;
        if (frame == kGalvoFramesPerTick) {
            const motion::Place at = segment.piece->place(segment.x(time_of(frame - 1)));
            field_x_ = at[kX] - anchor[kX];
            field_z_ = at[kZ] - anchor[kZ];
            field_depth_ = at[kY] - anchor[kY];
        }
    }
}

}  // namespace sc
