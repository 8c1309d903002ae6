// SPDX-License-Identifier: Apache-2.0
#include "host/verification/motion_svg.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "host/verification/motion_report.hpp"
#include "host/verification/svg.hpp"

namespace sc::host {

namespace {

constexpr double kWidth = 1200.0;
constexpr double kLeft = 78.0;
constexpr double kRight = 18.0;
constexpr double kTop = 64.0;
constexpr double kPanelHeight = 190.0;
constexpr double kPanelHead = 24.0;
constexpr double kGap = 14.0;
constexpr double kFoot = 40.0;
constexpr double kInner = kWidth - kLeft - kRight;
/// A scale that a single broken place would flatten ends at so many limits; what is beyond is cut off, and marked.
constexpr double kMostLimits = 3.0;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// One curve: its value at a sample, NaN where there is none.
struct Curve {
    std::string name;
    std::string_view css_class;
    std::function<double(std::size_t)> value;
};

struct LimitLine {
    std::string name;
    std::string_view css_class;
    double value = 0.0;
    bool is_signed = true;  ///< drawn on both sides of zero
};

struct Panel {
    std::string title;
    std::vector<Curve> curves;
    std::vector<LimitLine> limits;
    bool is_signed = true;
    std::vector<Breach> marks;  ///< which broken places belong here
    bool is_c = false;
};

/// Differences of a trace in base units, at rest where the drives begin to lead or to follow.
class Derivatives {
public:
    explicit Derivatives(const MotionTrace& trace) : trace_(&trace) {}
    [[nodiscard]] double of(std::size_t n, std::size_t axis, std::size_t order) const {
        if (trace_->led[n] == 0) {
            return kNone;
        }
        std::array<double, 4> v{};
        std::size_t at = n;
        for (double& value : v) {
            value = static_cast<double>(trace_->samples[at][axis]);
            at -= at > 0 && trace_->led[at - 1] != 0 ? 1U : 0U;
        }
        const double scale = 1.0 / (units_per_base(axis) * std::pow(trace_->period, static_cast<double>(order) + 1.0));
        switch (order) {
            case 0: return scale * (v[0] - v[1]);
            case 1: return scale * (v[0] - 2.0 * v[1] + v[2]);
            default: return scale * (v[0] - 3.0 * v[1] + 3.0 * v[2] - v[3]);
        }
    }
    [[nodiscard]] double norm_of(std::size_t n, std::size_t order) const {
        return norm(Vec3{of(n, 0, order), of(n, 1, order), of(n, 2, order)});
    }

private:
    const MotionTrace* trace_;
};

struct Range {
    double least = 0.0;
    double most = 0.0;
};

/// From samples and values to the picture.
struct Frame {
    double top = 0.0;
    Range range;
    std::size_t samples = 1;
    [[nodiscard]] double x(std::size_t n) const {
        const double last = std::max(1.0, static_cast<double>(samples) - 1.0);
        return kLeft + kInner * static_cast<double>(n) / last;
    }
    [[nodiscard]] double y(double value) const {
        const double part = (std::clamp(value, range.least, range.most) - range.least) / (range.most - range.least);
        return top + kPanelHead + kPanelHeight * (1.0 - part);
    }
};

/// The nearest of 1, 2, 5 · 10ⁿ that gives some `parts` divisions.
double step_of(double span, double parts) {
    const double raw = span / parts;
    const double power = std::pow(10.0, std::floor(std::log10(raw)));
    const double lead = raw / power;
    return power * (lead < 1.5 ? 1.0 : (lead < 3.5 ? 2.0 : (lead < 7.5 ? 5.0 : 10.0)));
}

Range range_of(const Panel& panel, std::size_t samples) {
    double largest = 0.0;
    for (const Curve& curve : panel.curves) {
        for (std::size_t n = 0; n < samples; ++n) {
            const double value = std::abs(curve.value(n));
            largest = value > largest ? value : largest;
        }
    }
    double limit = 0.0;
    for (const LimitLine& line : panel.limits) {
        limit = std::max(limit, line.value);
    }
    if (limit > 0.0) {
        largest = std::clamp(largest, limit, kMostLimits * limit);
    }
    largest = largest > 0.0 ? 1.08 * largest : 1.0;
    return {panel.is_signed ? -largest : 0.0, largest};
}

/// A line through least and greatest value of each column of pixels, broken where there is no value.
std::string curve_path(const Curve& curve, const Frame& frame) {
    std::string d;
    bool is_open = false;
    const auto point = [&](double x, double y) {
        fmt::format_to(std::back_inserter(d), "{}{:.1f} {:.1f}", is_open ? 'L' : 'M', x, y);
        is_open = true;
    };
    for (std::size_t n = 0; n < frame.samples;) {
        const double column = std::floor(frame.x(n));
        double least = std::numeric_limits<double>::infinity();
        double most = -least;
        double first = kNone;
        double last = kNone;
        bool has_hole = false;
        const double x = frame.x(n);
        for (; n < frame.samples && std::floor(frame.x(n)) == column; ++n) {
            const double value = curve.value(n);
            if (std::isnan(value)) {
                has_hole = true;
                continue;
            }
            first = std::isnan(first) ? value : first;
            last = value;
            least = std::min(least, value);
            most = std::max(most, value);
        }
        if (std::isnan(first)) {
            is_open = false;
            continue;
        }
        const bool falls = last < first;
        point(x, frame.y(falls ? most : least));
        if (most > least && frame.y(least) - frame.y(most) >= 0.05) {
            fmt::format_to(std::back_inserter(d), "V{:.1f}", frame.y(falls ? least : most));
        }
        is_open = is_open && !has_hole;
    }
    return d;
}

void draw_grid(Svg& svg, const Frame& frame, double seconds_before, double period) {
    const double bottom = frame.top + kPanelHead + kPanelHeight;
    const double span = frame.range.most - frame.range.least;
    const double step = step_of(span, 5.0);
    for (double i = std::ceil(frame.range.least / step); i * step <= frame.range.most; i += 1.0) {
        const double y = frame.y(i * step);
        svg.line(kLeft, y, kWidth - kRight, y, i == 0.0 ? "axis" : "grid");
        svg.text(kLeft - 6.0, y + 4.0, fmt::format("{:.6g}", i * step + 0.0), "small", "end");
    }
    const double seconds = period * std::max(1.0, static_cast<double>(frame.samples) - 1.0);
    const double time_step = step_of(seconds, 12.0);
    for (double i = std::ceil(seconds_before / time_step - 1e-9);
         i * time_step <= seconds_before + seconds * (1.0 + 1e-9); i += 1.0) {
        const double x = kLeft + kInner * (i * time_step - seconds_before) / seconds;
        svg.line(x, frame.top + kPanelHead, x, bottom, "grid");
        svg.text(x, bottom + 12.0, fmt::format("{:.6g}", i * time_step + 0.0), "small", "middle");
    }
}

void draw_limit(Svg& svg, const Frame& frame, const LimitLine& limit) {
    svg.line(kLeft, frame.y(limit.value), kWidth - kRight, frame.y(limit.value), limit.css_class);
    if (limit.is_signed) {
        svg.line(kLeft, frame.y(-limit.value), kWidth - kRight, frame.y(-limit.value), limit.css_class);
    }
}

void draw_legend(Svg& svg, const Panel& panel, double top) {
    double x = kWidth - kRight - 8.0;
    const auto entry = [&](const std::string& name, std::string_view css_class) {
        x -= 7.0 * static_cast<double>(name.size());
        svg.text(x, top + 16.0, name, "small");
        svg.line(x - 24.0, top + 12.0, x - 5.0, top + 12.0, css_class);
        x -= 40.0;
    };
    for (auto limit = panel.limits.rbegin(); limit != panel.limits.rend(); ++limit) {
        entry(limit->name, limit->css_class);
    }
    for (auto curve = panel.curves.rbegin(); curve != panel.curves.rend(); ++curve) {
        entry(curve->name, curve->css_class);
    }
}

void draw_marks(Svg& svg, const Panel& panel, const Frame& frame, const MotionReport& report, std::int64_t first_tick) {
    double drawn = -1.0;
    for (const Violation& v : report.first) {
        const bool is_here =
            std::ranges::find(panel.marks, v.breach) != panel.marks.end() && (v.axis == "c") == panel.is_c;
        const std::int64_t n = v.tick - first_tick;
        if (!is_here || n < 0 || n >= static_cast<std::int64_t>(frame.samples)) {
            continue;
        }
        const double x = frame.x(static_cast<std::size_t>(n));
        if (std::abs(x - drawn) < 2.0) {
            continue;
        }
        drawn = x;
        svg.open_group(violation_text(v));
        svg.line(x, frame.top + kPanelHead, x, frame.top + kPanelHead + kPanelHeight, "broken");
        svg.circle(x, frame.top + kPanelHead, 4.0, "brokendot");
        svg.close_group();
    }
}

/// One line for the three axes if their limits are the same, else one each in the axis' own colour.
std::vector<LimitLine> axis_limits(const MotionLimits& limits, double AxisLimits::* quantity) {
    const double x = limits.axis[0].*quantity;
    const double y = limits.axis[1].*quantity;
    const double z = limits.axis[2].*quantity;
    if (x == y && x == z) {
        return {{"limit", "limit", x, true}};
    }
    return {
        {"limit of x", "limit lx", x, true}, {"limit of y", "limit ly", y, true}, {"limit of z", "limit lz", z, true}};
}

std::vector<Panel> panels_of(const MotionTrace& trace, const MotionLimits& limits, const MotionReport& report,
                             const Derivatives& derivatives) {
    struct Quantity {
        const char* name;
        const char* unit;
        double AxisLimits::* limit;
        Breach breach;
    };
    constexpr std::array<Quantity, 3> kQuantities{
        Quantity{"speed", "s", &AxisLimits::speed, Breach::speed},
        Quantity{"acceleration", "s²", &AxisLimits::acceleration, Breach::acceleration},
        Quantity{"jerk", "s³", &AxisLimits::jerk, Breach::jerk}};
    constexpr std::array<const char*, 4> kNames{"x", "y", "z", "c"};
    constexpr std::array<std::string_view, 4> kClasses{"cx", "cy", "cz", "cc"};
    std::vector<Panel> panels;
    for (std::size_t k = 0; k < 3; ++k) {
        const Quantity& q = kQuantities[k];
        Panel panel{.title = fmt::format("{}, m/{}", q.name, q.unit),
                    .curves = {},
                    .limits = axis_limits(limits, q.limit),
                    .marks = {q.breach}};
        panel.curves.push_back(
            {"path (norm)", "cp", [&derivatives, k](std::size_t n) { return derivatives.norm_of(n, k); }});
        for (std::size_t i = 0; i < 3; ++i) {
            panel.curves.push_back(
                {kNames[i], kClasses[i], [&derivatives, i, k](std::size_t n) { return derivatives.of(n, i, k); }});
        }
        if (k == 0) {
            if (limits.path_speed) {
                panel.limits.push_back({"limit of path", "pathlimit", *limits.path_speed, false});
            }
            panel.marks.insert(panel.marks.end(),
                               {Breach::not_at_rest, Breach::travel, Breach::keep_out, Breach::turn_not_retracted,
                                Breach::galvo_field, Breach::gate_outside_marking});
        }
        panels.push_back(std::move(panel));
    }
    const auto moves = [&](std::size_t axis) {
        return std::ranges::any_of(trace.samples,
                                   [&](const AxisPositions& s) { return s[axis] != trace.samples[0][axis]; });
    };
    for (std::size_t k = 0; k < 3 && moves(3); ++k) {
        const Quantity& q = kQuantities[k];
        Panel panel{.title = fmt::format("{} of C, degrees/{}", q.name, q.unit),
                    .curves = {},
                    .limits = {{"limit", "limit", limits.axis[3].*q.limit, true}},
                    .marks = {q.breach},
                    .is_c = true};
        panel.curves.push_back(
            {"c", kClasses[3], [&derivatives, k](std::size_t n) { return derivatives.of(n, 3, k); }});
        if (k == 0) {
            panel.marks.insert(panel.marks.end(), {Breach::not_at_rest, Breach::travel});
        }
        panels.push_back(std::move(panel));
    }
    if (report.deviation) {
        const std::vector<float>& of_sample = report.deviation->of_sample;
        Panel panel{.title = "deviation from the path, µm",
                    .curves = {},
                    .limits = {{"limit", "limit", report.tolerance * 1e6, false}},
                    .is_signed = false,
                    .marks = {Breach::deviation, Breach::path_end, Breach::vertex_skipped, Breach::path_lost}};
        panel.curves.push_back(
            {"deviation", "cp", [&of_sample](std::size_t n) { return 1e6 * static_cast<double>(of_sample[n]); }});
        panels.push_back(std::move(panel));
    }
    return panels;
}

}  // namespace

std::string motion_svg(std::string_view title, const MotionTrace& trace, const MotionLimits& limits,
                       const MotionReport& report) {
    const Derivatives derivatives(trace);
    const std::vector<Panel> panels = panels_of(trace, limits, report, derivatives);
    const double pitch = kPanelHead + kPanelHeight + kGap + 8.0;
    const double height = kTop + pitch * static_cast<double>(panels.size()) + kFoot;
    Svg svg(kWidth, height);
    svg.rect(0.0, 0.0, kWidth, height, "page");
    svg.text(kLeft, 30.0, fmt::format("{}: {}", title, motion_verdict(report)), "title");
    svg.text(
        kLeft, 50.0,
        fmt::format("{} ticks from tick {}, {:.3f} s; worst ratio to a limit {:.4f}, passed up to {:g}",
                    trace.samples.size(), trace.first_tick, report.seconds, report.max_limit_ratio(), report.allow),
        "small");
    double top = kTop;
    for (const Panel& panel : panels) {
        const Frame frame{top, range_of(panel, trace.samples.size()), trace.samples.size()};
        svg.rect(kLeft, top + kPanelHead, kInner, kPanelHeight, "panel");
        draw_grid(svg, frame, trace.period * static_cast<double>(trace.first_tick), trace.period);
        svg.text(kLeft, top + 16.0, panel.title, "head");
        for (const Curve& curve : panel.curves) {
            svg.path(curve_path(curve, frame), curve.css_class);
        }
        for (const LimitLine& limit : panel.limits) {
            draw_limit(svg, frame, limit);
        }
        draw_marks(svg, panel, frame, report, trace.first_tick);
        draw_legend(svg, panel, top);
        top += pitch;
    }
    svg.text(kLeft + 0.5 * kInner, height - 14.0, "time, s", "small", "middle");
    return svg.finish();
}

}  // namespace sc::host
