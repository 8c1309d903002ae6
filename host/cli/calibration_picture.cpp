// SPDX-License-Identifier: Apache-2.0
#include "host/cli/calibration_picture.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "host/calibration/scribe_budget.hpp"
#include "host/cli/calibration_age.hpp"
#include "host/formats/calibration_records.hpp"
#include "host/formats/iso_time.hpp"
#include "host/verification/svg.hpp"

namespace sc::host::cli {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kWidth = 900.0;
constexpr double kStep = 330.0;
constexpr double kRow = 84.0;
constexpr double kTop = 100.0;
constexpr double kLeft = 60.0;

struct Node {
    std::string frame;
    int depth = 0;
    int parent = -1;
    std::string record;  ///< that leads to it
    double y = 0.0;
};

std::string name_of_frame(const std::string& letter) {
    static const std::map<std::string, std::string> names{
        {"h", "scribing"},      {"c", "measurement"}, {"b", "robot base"}, {"f", "flange"},    {"g", "fixed target"},
        {"m", "mobile target"}, {"t", "turntable"},   {"w", "workpiece"},  {"r", "reference"}, {"d", "triple head"}};
    const auto found = names.find(letter);
    return found == names.end() ? "" : found->second;
}

/// Depth first, so that branches do not cross. Frames that hang on nothing begin trees of their own.
std::vector<Node> tree_of(const CalibrationSet& set) {
    std::vector<std::pair<std::array<std::string, 2>, std::string>> edges;
    for (const TransformRecord& record : set.transforms) {
        if (const auto frames = frames_of(record.id)) {
            edges.emplace_back(*frames, record.id);
        }
    }
    if (set.turntable) {
        edges.emplace_back(std::array<std::string, 2>{"h", "t"}, "turntable");
    }
    std::vector<Node> out;
    const auto known = [&out](const std::string& frame) {
        return std::ranges::find(out, frame, &Node::frame) != out.end();
    };
    const auto grow = [&](const auto& self, const std::string& frame, int depth, int parent,
                          const std::string& record) -> void {
        const auto me = static_cast<int>(out.size());
        out.push_back({frame, depth, parent, record, 0.0});
        for (const auto& [frames, id] : edges) {
            for (const std::size_t side : {0U, 1U}) {
                if (frames.at(side) == frame && !known(frames.at(1 - side))) {
                    self(self, frames.at(1 - side), depth + 1, me, id);
                }
            }
        }
    };
    grow(grow, "h", 0, -1, "");
    for (const auto& edge : edges) {
        if (!known(edge.first[0])) {
            grow(grow, edge.first[0], 0, -1, "");
        }
    }
    return out;
}

/// "12 um, 0.5 mdeg": root of the mean variance of place and of turn.
std::string sigma_of(const CovarianceBlock& block) {
    double places = 0.0;
    double turns = 0.0;
    double place_count = 0.0;
    double turn_count = 0.0;
    for (std::size_t i = 0; i < block.at.size(); ++i) {
        (block.lengths[i] == 1 ? places : turns) += block.at[i][i];
        (block.lengths[i] == 1 ? place_count : turn_count) += 1.0;
    }
    return fmt::format("{:.3g} um, {:.3g} mdeg", 1e6 * std::sqrt(places / std::max(1.0, place_count)),
                       1e3 / kDegree * std::sqrt(turns / std::max(1.0, turn_count)));
}

std::string age_of(const RecordSummary& record, std::chrono::sys_seconds now, bool& expired) {
    const auto made = parse_iso_time(record.time);
    const auto end = expiry_of(record.time, record.validity);
    expired = end && *end <= now;
    std::string out = made ? span_text(now - *made) + " old" : "";
    if (end) {
        out += expired ? fmt::format(", EXPIRED {} ago", span_text(now - *end))
                       : fmt::format(", good for {}", span_text(*end - now));
    }
    return out;
}

}  // namespace

std::string calibration_svg(const CalibrationSet& set, std::chrono::sys_seconds now) {
    std::vector<Node> nodes = tree_of(set);
    double y = kTop;
    // A child stands in its parent's row if it is the first, else in a row of its own.
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const bool first = i > 0 && nodes[i].parent == static_cast<int>(i) - 1;
        y += i == 0 || first ? 0.0 : kRow;
        nodes[i].y = y;
    }
    const std::vector<RecordSummary> records = record_summaries(set);
    const std::vector<CovarianceBlock> blocks = covariance_blocks(set);
    const double table = y + kRow;
    const double height = table + 20.0 * static_cast<double>(records.size()) + 30.0;
    int deepest = 0;
    for (const Node& node : nodes) {
        deepest = std::max(deepest, node.depth);
    }
    const double width = std::max(kWidth, 2.0 * kLeft + kStep * deepest + 120.0);
    Svg svg(width, height);
    svg.rect(0, 0, width, height, "page");
    svg.text(24, 32, "Calibration set " + set.id, "title");
    svg.text(24, 52, fmt::format("made {}, sha256 {}", set.time, set.sha256.substr(0, 12)), "small");
    for (const Node& node : nodes) {
        const double x = kLeft + kStep * node.depth;
        if (node.parent >= 0) {
            const Node& parent = nodes[static_cast<std::size_t>(node.parent)];
            const double from = kLeft + kStep * parent.depth;
            svg.line(from + 22, parent.y, x - 22, node.y, "bar");
            const auto record = std::ranges::find(records, node.record, &RecordSummary::id);
            const auto block = std::ranges::find(blocks, node.record, &CovarianceBlock::id);
            const double middle = x - 0.5 * kStep;
            const double over = node.y - (parent.y == node.y ? 0.0 : 4.0);
            svg.text(middle, over - 8, node.record, "head", "middle");
            if (block != blocks.end()) {
                svg.text(middle, over + 16, sigma_of(*block), "small", "middle");
            }
            if (record != records.end()) {
                bool expired = false;
                const std::string age = age_of(*record, now, expired);
                svg.text(middle, over + 30, age, "small", "middle");
                if (expired) {
                    svg.circle(middle, over, 5, "brokendot");
                }
            }
        }
        svg.circle(x, node.y, 20, "panel");
        svg.text(x, node.y + 5, node.frame, "title", "middle");
        svg.text(x, node.y + 36, name_of_frame(node.frame), "small", "middle");
    }
    double row = table;
    for (const RecordSummary& record : records) {
        bool expired = false;
        const std::string age = age_of(record, now, expired);
        svg.text(24, row, record.id, "no");
        svg.text(150, row, age, "small");
        svg.text(400, row,
                 record.residual_rms ? fmt::format("residuals {:.2f} um rms", 1e6 * *record.residual_rms) : "",
                 "small");
        row += 20.0;
    }
    return svg.finish();
}

}  // namespace sc::host::cli
