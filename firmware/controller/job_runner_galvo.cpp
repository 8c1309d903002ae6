// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <span>

#include "firmware/controller/job_runner.hpp"
#include "firmware/laser/frame_polynomial.hpp"
#include "shared/math/scalar.hpp"

namespace sc {
namespace {

/// Frames that share one patch of the field correction. So many that the mirrors cover this range, which holds it
/// within FieldMap::patch's 0.25 mm either side, and at an end near by 0.32 mm.
constexpr double kPatchRange = 0.5e-3;
constexpr double kJumpPatchFrames = 25.0;
struct PatchFrames {
    std::size_t usual;
    std::size_t most;
    std::size_t fewest;
    explicit PatchFrames(double frames) noexcept
        : usual(static_cast<std::size_t>(clamped(frames, kJumpPatchFrames, 64.0))),
          most(usual + 9 * usual / 32),
          fewest(usual / 2 + 2) {}
    /// Of the patch that begins where the path's segment has `left` more. It ends where the segment does if that is
    /// near, since each pair of both costs its polynomials.
    [[nodiscard]] std::size_t before(std::size_t left) const noexcept {
        if (left < fewest) {
            return usual;
        }
        if (left <= most) {
            return left;
        }
        return left < 2 * usual ? (left + 1) / 2 : usual;
    }
};

/// Frames at a tick's end for which the stage's last piece may serve beyond its own end: within 0.1 nm at full jerk.
constexpr std::size_t kLateFrames = 10;

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
    const auto cubic = [&](std::size_t i) noexcept { return piece.axis[i][4] == 0.0 && piece.axis[i][5] == 0.0; };
    return cubic(kX) && cubic(kZ) && cubic(kY);
}

bool is_level(const trajectory::Quintic& q) noexcept {
    return q[1] == 0.0 && q[2] == 0.0 && q[3] == 0.0 && q[4] == 0.0 && q[5] == 0.0;
}

/// Where the axes are over the frames of a tick: cubics in the number of the frame, metres.
using StageLaw = std::array<laser::FramePolynomial<3>, 3>;

/// What the frames of a tick have in common.
struct FrameLaw {
    const laser::FieldMap& map;
    motion::Place anchor;   ///< where the axes stand
    const StageLaw* stage;  ///< or how they move
    double period;          ///< s
    double per_step;        ///< GalvoLead in frames
    double per_step2;       ///< … and in frames²
    laser::FieldPatch patch;
    double first;  ///< frame of the tick at which those to be put begin
    [[nodiscard]] bool level() const noexcept {
        const laser::FramePolynomial<3>& y = (*stage)[kY];
        return y[1] == 0.0 && y[2] == 0.0 && y[3] == 0.0;
    }
    [[nodiscard]] double stage_at(std::size_t axis, double frame) const noexcept {
        return stage == nullptr ? anchor[axis] : laser::value<3>((*stage)[axis], frame);
    }
};

/// Takes from a place what the stage does of it, frames counted from law.first.
template <std::size_t kDegree>
void take_stage(laser::FramePolynomial<kDegree>& place, const FrameLaw& law, std::size_t axis) noexcept {
    const laser::FramePolynomial<3>& s = (*law.stage)[axis];
    const double k = law.first;
    place[0] -= laser::value<3>(s, k);
    place[1] -= s[1] + k * (2.0 * s[2] + 3.0 * k * s[3]);
    place[2] -= s[2] + 3.0 * k * s[3];
    place[3] -= s[3];
}

/// A place over the frames, and the place that the mirrors are sent to for it.
template <std::size_t kDegree>
struct FramePlaces {
    laser::FramePolynomial<kDegree> x;
    laser::FramePolynomial<kDegree> z;
    laser::FramePolynomial<kDegree> x_led;
    laser::FramePolynomial<kDegree> z_led;
    laser::FramePolynomial<kDegree> depth;
};

/// Words for places and the places asked for, by the number of the frame. Called, not inlined: one for all whose frames
/// are of this degree.
template <GalvoWord kWord, std::size_t kDegree>
[[gnu::noinline]] void fill_frames(const laser::FieldPatch& patch, const FramePlaces<kDegree>& at,
                                   std::span<GalvoFrame> frames) noexcept {
    using Polynomial = laser::FramePolynomial<kDegree>;
    const auto counts = [&](std::size_t mirror) noexcept {
        const std::array<double, 3>& m = patch.m[mirror];
        Polynomial sum;
        for (std::size_t n = 0; n <= kDegree; ++n) {
            sum[n] = m[0] * at.x_led[n] + m[1] * at.z_led[n] + m[2] * at.depth[n];
        }
        sum[0] += patch.offset[mirror];
        return sum;
    };
    // Two loops: the differences of two polynomials are what a core's registers hold.
    laser::FrameValues<kDegree> count_x(counts(0));
    laser::FrameValues<kDegree> count_z(counts(1));
    const laser::WordFormat format = patch.format;
    for (GalvoFrame& frame : frames) {
        const auto words =
            format.clamped_words<kWord>(nearest32_within(count_x.value()), nearest32_within(count_z.value()));
        frame.word_x = words[0];
        frame.word_z = words[1];
        count_x.next();
        count_z.next();
    }
    const auto picometres = [](const Polynomial& place) noexcept {
        Polynomial scaled;
        for (std::size_t n = 0; n <= kDegree; ++n) {
            scaled[n] = place[n] * kPmPerMetre;
        }
        return scaled;
    };
    laser::FrameValues<kDegree> x(picometres(at.x));
    laser::FrameValues<kDegree> z(picometres(at.z));
    for (GalvoFrame& frame : frames) {
        frame.x_pm = nearest_within(x.value());
        frame.z_pm = nearest_within(z.value());
        x.next();
        z.next();
    }
}

/// Frames of one segment under one patch, from path time t on: the words' counts are polynomials too. A new patch is
/// made for the place at frame `middle`, if that is not negative.
template <GalvoWord kWord, std::size_t kDegree, bool kMoving>
void put_frames(FrameLaw& law, const motion::Segment& segment, double t, double middle,
                std::span<GalvoFrame> frames) noexcept {
    using Polynomial = laser::FramePolynomial<kDegree>;
    const double begin = segment.x(t);
    const double step = law.period * segment.rate;
    const auto place_of = [&](std::size_t axis) noexcept {
        Polynomial place = laser::over_frames<kDegree>(segment.piece->axis[axis], begin, step);
        if constexpr (kMoving) {
            take_stage<kDegree>(place, law, axis);
        } else {
            place[0] -= law.anchor[axis];
        }
        return place;
    };
    Polynomial place_x = place_of(kX);
    Polynomial place_z = place_of(kZ);
    const Polynomial x_led = laser::led<kDegree>(place_x, law.per_step, law.per_step2);
    const Polynomial z_led = laser::led<kDegree>(place_z, law.per_step, law.per_step2);
    Polynomial depth{};
    if (is_level(segment.piece->axis[kY]) && (!kMoving || law.level())) {
        depth[0] = segment.piece->axis[kY][0] - (kMoving ? (*law.stage)[kY][0] : law.anchor[kY]);
    } else {
        depth = laser::led<kDegree>(place_of(kY), law.per_step, law.per_step2);
    }
    if (middle >= 0.0) {
        law.patch = law.map.patch(laser::value<kDegree>(x_led, middle), laser::value<kDegree>(z_led, middle),
                                  laser::value<kDegree>(depth, middle));
    }
    const auto counts = [&](std::size_t mirror) noexcept {
        const std::array<double, 3>& m = law.patch.m[mirror];
        Polynomial sum;
        for (std::size_t n = 0; n <= kDegree; ++n) {
            sum[n] = m[0] * x_led[n] + m[1] * z_led[n] + m[2] * depth[n];
        }
        sum[0] += law.patch.offset[mirror];
        return sum;
    };
    // Two loops: the differences of two polynomials are what a core's registers hold.
    laser::FrameValues<kDegree> count_x(counts(0));
    laser::FrameValues<kDegree> count_z(counts(1));
    const laser::WordFormat format = law.patch.format;
    for (GalvoFrame& frame : frames) {
        const auto words =
            format.clamped_words<kWord>(nearest32_within(count_x.value()), nearest32_within(count_z.value()));
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

bool JobRunner::follow_axes(ServoOutputs& out) noexcept {
    if (machine_.galvo.follow == FollowAxes::off) {
        return false;
    }
    const bool marking = phase_ == Phase::path && path_.actuator == Actuator::axes;
    const auto shift = follower_.step(tick_, marking, place_[kY] - machine_.table_y.si());
    if (!shift) {
        return false;
    }
    constexpr double kPerFrame = 1.0 / static_cast<double>(kGalvoFramesPerTick);
    const auto over_frames = [](double still, const AxisFollower::Cubic& c) noexcept {
        return laser::FramePolynomial<3>{still + c.place, c.speed * kPerFrame, c.bend * (kPerFrame * kPerFrame),
                                         c.twist * (kPerFrame * kPerFrame * kPerFrame)};
    };
    const laser::FramePolynomial<3> x = over_frames(field_x_, shift->x);
    const laser::FramePolynomial<3> z = over_frames(field_z_, shift->z);
    const laser::FramePolynomial<3> depth{field_depth_, 0.0, 0.0, 0.0};
    const laser::FieldPatch patch = field_patch({x[0], field_depth_, z[0], 0.0});
    const std::span<GalvoFrame> frames(out.galvo);
    if (machine_.galvo.word == GalvoWord::bits18) {
        fill_frames<GalvoWord::bits18, 3>(patch, {x, z, x, z, depth}, frames);
    } else {
        fill_frames<GalvoWord::bits16, 3>(patch, {x, z, x, z, depth}, frames);
    }
    return true;
}

void JobRunner::galvo_still(ServoOutputs& out) noexcept {
    if (follow_axes(out)) {
        return;
    }
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
    constexpr auto kPatch = static_cast<std::size_t>(kJumpPatchFrames);
    laser::FieldPatch patch;
    for (std::size_t k = 0; k < kGalvoFramesPerTick; ++k) {
        if (k % kPatch == 0) {
            patch = field_patch(field_at(k + kPatch / 2));
        }
        const motion::Place field = field_at(k);
        put_frame(out.galvo[k], field[kX], field[kZ], patch.words({field[kX], field[kZ], field[kY]}));
        field_x_ = field[kX];
        field_z_ = field[kZ];
        field_depth_ = field[kY];
    }
}

void JobRunner::galvo_path(motion::Segment segment, double t, ServoOutputs& out) noexcept {
    const double period = exact_double(machine_.galvo_period_ns) * 1e-9;
    const bool wide = machine_.galvo.word == GalvoWord::bits18;
    const bool split = path_.actuator == Actuator::split;
    const auto put_fixed = wide ? put_frames<GalvoWord::bits18, 5, false> : put_frames<GalvoWord::bits16, 5, false>;
    const auto put_moving = wide ? put_frames<GalvoWord::bits18, 5, true> : put_frames<GalvoWord::bits16, 5, true>;
    const auto put_line = wide ? put_frames<GalvoWord::bits18, 3, false> : put_frames<GalvoWord::bits16, 3, false>;
    const auto put = split ? put_moving : put_fixed;
    // Cubics with a moving stage would cost more flash than they save.
    const auto put_cubic = split ? put_moving : put_line;
    const auto time_of = [&](std::size_t frame) noexcept {
        return t + exact_double(static_cast<std::int64_t>(frame)) * period;
    };
    StageLaw stage;
    FrameLaw law{field_,
                 {metres(path_.anchor_x), metres(path_.anchor_y), metres(path_.anchor_z), 0.0},
                 split ? &stage : nullptr,
                 period,
                 lead_.per_velocity / period,
                 lead_.per_acceleration / (period * period),
                 field_.flat(),
                 0.0};
    const double per_tick = exact_double(machine_.galvo_period_ns) / exact_double(machine_.control_period_ns);
    const double per_tick2 = per_tick * per_tick;
    const double per_tick3 = per_tick2 * per_tick;
    std::array<double, 3> late{};
    const auto take_law = [&](bool next) noexcept {
        for (const std::size_t axis : {kX, kY, kZ}) {
            const motion::StageHistory::Cubic x = history_.law(axis, late[axis], next);
            stage[axis] = {x[0], x[1] * per_tick, x[2] * per_tick2, x[3] * per_tick3};
        }
    };
    std::size_t stage_end = kGalvoFramesPerTick;
    if (split) {
        late = {stage_late(kX), stage_late(kY), stage_late(kZ)};
        take_law(false);
        const double frames = motion::StageHistory::next_begins(late[kX]) / per_tick;
        const auto whole = static_cast<std::size_t>(clamped(frames, 0.0, static_cast<double>(kGalvoFramesPerTick)));
        stage_end = whole + kLateFrames < kGalvoFramesPerTick ? whole + 1 : kGalvoFramesPerTick;
    }
    motion::Cursor ahead = cursor_;
    // A stage that goes against the mirrors adds a hundredth of a millimetre.
    const PatchFrames patch_frames(kPatchRange / (exact_double(path_.speed_um_s) * 1e-6 * period));
    std::size_t patch_end = field_.curved() ? 0 : kGalvoFramesPerTick;
    std::size_t frame = 0;
    while (frame < kGalvoFramesPerTick) {
        if (frame == stage_end) {
            take_law(true);
            stage_end = kGalvoFramesPerTick;
        }
        law.first = static_cast<double>(frame);
        const double now = time_of(frame);
        if (!(now < segment.end)) {
            segment = motion_.segment_after(segment, now, cursor_);
        }
        // Frames before the segment's end, at least this one.
        const double left = clamped((segment.end - now) / period, 1.0, static_cast<double>(kGalvoFramesPerTick));
        const auto whole = static_cast<std::uint32_t>(left);
        const std::size_t count = whole + (left > static_cast<double>(whole) ? 1U : 0U);
        double middle = -1.0;
        if (frame == patch_end) {
            const std::size_t frames = patch_frames.before(count);
            const double half = 0.5 * exact_double(static_cast<std::int64_t>(frames));
            if (frames <= count) {
                middle = half;
            } else {
                // Beyond this segment, whose polynomials do not hold there.
                const double then = now + half * period + lead_.per_velocity;
                const motion::Segment there = motion_.segment(then, ahead);
                const motion::Place at = there.piece->place(there.x(then));
                const double there_frame = law.first + half;
                law.patch = field_patch({at[kX] - law.stage_at(kX, there_frame), at[kY] - law.stage_at(kY, there_frame),
                                         at[kZ] - law.stage_at(kZ, there_frame), 0.0});
            }
            patch_end += frames;
        }
        const std::size_t last = std::min({frame + count, patch_end, stage_end, kGalvoFramesPerTick});
        (is_cubic(*segment.piece) ? put_cubic : put)(law, segment, now, middle,
                                                     std::span(out.galvo).subspan(frame, last - frame));
        frame = last;
        if (frame == kGalvoFramesPerTick) {
            const motion::Place at = segment.piece->place(segment.x(time_of(frame - 1)));
            const double end = static_cast<double>(frame - 1);
            field_x_ = at[kX] - law.stage_at(kX, end);
            field_z_ = at[kZ] - law.stage_at(kZ, end);
            field_depth_ = at[kY] - law.stage_at(kY, end);
        }
    }
}

}  // namespace sc
