// SPDX-License-Identifier: Apache-2.0
#include "host/cli/register_view.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host/cli/calibrate_places.hpp"
#include "host/formats/file.hpp"
#include "host/verification/svg.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kSide = 760.0;
constexpr double kTop = 70.0;
constexpr double kInset = 40.0;
constexpr double kArrow = 1000.0;

/// Two directions of c that the picture shows: across the axis, else the two in which the markers spread most.
struct Sheet {
    Vec3 right;
    Vec3 up;
};

Sheet sheet_of(const ChainResult& chain) {
    Vec3 normal{0.0, 0.0, 1.0};
    if (chain.axis) {
        normal = chain.axis->direction;
    }
    const Vec3 other = std::abs(normal.x) < 0.8 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
    const Vec3 up = cross(normal, other);
    const Vec3 unit_up = (1.0 / norm(up)) * up;
    return {cross(unit_up, normal), unit_up};
}

class Map {
public:
    explicit Map(const ChainResult& chain) : sheet_(sheet_of(chain)) {
        for (const ChainResidual& r : chain.residuals) {
            grow(r.place);
        }
        scale_ = (kSide - 2.0 * kInset) / std::max({most_x_ - least_x_, most_y_ - least_y_, 1e-6});
    }
    [[nodiscard]] double x(const Vec3& p) const { return kInset + scale_ * (dot(p, sheet_.right) - least_x_); }
    [[nodiscard]] double y(const Vec3& p) const { return kTop + kInset + scale_ * (most_y_ - dot(p, sheet_.up)); }
    [[nodiscard]] double height() const { return kTop + 2.0 * kInset + scale_ * (most_y_ - least_y_); }
    [[nodiscard]] double scale() const { return scale_; }

private:
    void grow(const Vec3& p) {
        least_x_ = std::min(least_x_, dot(p, sheet_.right));
        most_x_ = std::max(most_x_, dot(p, sheet_.right));
        least_y_ = std::min(least_y_, dot(p, sheet_.up));
        most_y_ = std::max(most_y_, dot(p, sheet_.up));
    }
    Sheet sheet_;
    double least_x_ = 1e300;
    double most_x_ = -1e300;
    double least_y_ = 1e300;
    double most_y_ = -1e300;
    double scale_ = 1.0;
};

double sigma_um(const ChainMarkerResult& m) {
    const auto& c = m.covariance.at;
    return 1e6 * std::sqrt((c[0][0] + c[1][1] + c[2][2]) / 3.0);
}

}  // namespace

void add_chain_words(CLI::App& sub, ChainWords& words) {
    const CLI::Range some(1e-6, 1e9);
    sub.add_option("--scan-set", words.scan_set, "views: markers, angle of the table, robot poses")
        ->type_name("FILE")
        ->required();
    sub.add_option("--target", words.targets,
                   "targets whose markers stand still (several); a fixed one with measured places gives c")
        ->type_name("FILE");
    sub.add_option("--still", words.still, "further ids of markers that stand still; all others turn with the table")
        ->type_name("ID")
        ->delimiter(',');
    sub.add_flag("--ids-unknown", words.ids_unknown, "numbers in the views mean nothing: match by mutual distances");
    sub.add_option("--tolerance-um", words.tolerance_um, "for that")->check(some)->capture_default_str();
    sub.add_option("--sensor-um", words.sensor_um, "noise of a marker that states none")
        ->check(some)
        ->capture_default_str();
    sub.add_option("--table-mdeg", words.table_mdeg, "noise of an angle")->check(some)->capture_default_str();
    sub.add_option("--robot", words.robot,
                   "robot poses are weighed by the noise they show, trusted as stated, or left-out")
        ->check(CLI::IsMember({"weighed", "trusted", "left-out"}))
        ->capture_default_str();
    sub.add_option("--robot-um", words.robot_um, "noise of a robot pose")->check(some)->capture_default_str();
    sub.add_option("--robot-mdeg", words.robot_mdeg, "noise of a robot pose")->check(some)->capture_default_str();
    sub.add_flag("--keep-all", words.keep_all, "leave nothing out");
    sub.add_option("--map", words.map, "target file to write: what stands still, with its places in c")
        ->type_name("FILE");
    sub.add_option("--svg", words.svg, "picture to write: markers and what is left of each sighting")
        ->type_name("FILE");
    sub.add_flag("--json", words.json, "one JSON object");
}

ScanTargets targets_of(const ChainWords& words) {
    ScanTargets out;
    for (const std::string& file : words.targets) {
        out.targets.push_back(read_target(file));
    }
    out.still = words.still;
    out.ids_unknown = words.ids_unknown;
    out.tolerance = words.tolerance_um * 1e-6;
    return out;
}

ChainOptions options_of(const ChainWords& words) {
    ChainOptions out;
    out.sigma = words.sensor_um * 1e-6;
    out.table = words.table_mdeg * 1e-3 * kDegree;
    out.robot_place = words.robot_um * 1e-6;
    out.robot_turn = words.robot_mdeg * 1e-3 * kDegree;
    out.robot = words.robot == "weighed"   ? RobotUse::weighed
                : words.robot == "trusted" ? RobotUse::trusted
                                           : RobotUse::left_out;
    out.find_wrong = !words.keep_all;
    return out;
}

Json chain_json(const ChainResult& chain) {
    Json views = Json::array();
    for (const ChainViewResult& v : chain.views) {
        Json view{{"view", v.name},
                  {"c_deg", v.turn / kDegree},
                  {"c_off_mdeg", v.turn_off / kDegree * 1e3},
                  {"c_wrong", v.turn_wrong},
                  {"markers", v.markers},
                  {"rms_um", v.rms * 1e6},
                  {"sigma_rotation_mdeg", v.turn_sigma / kDegree * 1e3},
                  {"sigma_place_um", v.place_sigma * 1e6}};
        if (v.robot) {
            view["robot_off_um"] = v.robot_off * 1e6;
            view["robot_off_mdeg"] = v.robot_turn_off / kDegree * 1e3;
        }
        views.push_back(std::move(view));
    }
    Json markers = Json::array();
    for (const ChainMarkerResult& m : chain.markers) {
        markers.push_back({{"id", m.id},
                           {"turns", m.turns},
                           {"place_mm", vector_json(1e3 * m.place)},
                           {"sigma_um", sigma_um(m)},
                           {"seen", m.seen},
                           {"left_out", m.wrong},
                           {"rms_um", m.rms * 1e6}});
    }
    Json findings = Json::array();
    for (const MarkerFinding& f : chain.findings) {
        findings.push_back({{"view", f.view}, {"id", f.id}, {"text", f.text()}});
    }
    Json out{{"format", "scribecell-chain"}, {"version", 1}};
    if (chain.h_from_c) {
        out["h_from_c"] =
            transform_json(chain.h_from_c->rotation, chain.h_from_c->translation, chain.h_from_c->covariance);
        out["pointing_rms_um"] = chain.pointing_rms * 1e6;
    }
    if (chain.axis) {
        out["axis_in_c"] = {{"point_mm", vector_json(1e3 * chain.axis->point)},
                            {"direction", vector_json(chain.axis->direction)},
                            {"direction_sigma_mdeg", chain.axis->turn_sigma / kDegree * 1e3},
                            {"place_sigma_um", chain.axis->place_sigma * 1e6}};
    }
    if (chain.axis_in_h) {
        out["axis_in_h"] = {{"point_mm", vector_json(1e3 * chain.axis_in_h->line.point.v)},
                            {"direction", vector_json(chain.axis_in_h->line.direction.v)},
                            {"covariance", chain.axis_in_h->covariance.at}};
    }
    if (chain.together) {
        out["covariance_together"] = {{"order", "rx,ry,rz,tx,ty,tz,px,py,dx,dy"}, {"covariance", chain.together->at}};
    }
    if (!chain.places.empty()) {
        Json places = Json::array();
        for (const ChainPlace& p : chain.places) {
            places.push_back({{"id", p.id},
                              {"face_deg", p.face_deg},
                              {"place_mm", vector_json(1e3 * p.place)},
                              {"covariance", p.covariance.at}});
        }
        out["places"] = std::move(places);
    }
    out["rms_um"] = chain.rms * 1e6;
    out["chi_squared"] = chain.chi_squared;
    out["freedom"] = chain.freedom;
    out["sigma_raised"] = chain.raised;
    out["robot_noise_ratio"] = chain.robot_ratio;
    out["wrong"] = std::move(findings);
    out["bad_views"] = chain.bad_views;
    out["notes"] = chain.notes;
    out["views"] = std::move(views);
    out["markers"] = std::move(markers);
    return out;
}

std::string chain_text(const ChainResult& chain) {
    std::string out =
        fmt::format("{} views, {} markers; rms {:.2f} um each coordinate, chi-squared {:.0f} of {:.0f}\n",
                    chain.views.size(), chain.markers.size(), chain.rms * 1e6, chain.chi_squared, chain.freedom);
    if (chain.h_from_c) {
        const auto& c = chain.h_from_c->covariance.at;
        out += "h_from_c:\n" + transform_text(chain.h_from_c->rotation, chain.h_from_c->translation) +
               fmt::format("  1 sigma: {:.3g}, {:.3g}, {:.3g} mdeg\n", std::sqrt(c[0][0]) / kDegree * 1e3,
                           std::sqrt(c[1][1]) / kDegree * 1e3, std::sqrt(c[2][2]) / kDegree * 1e3);
    }
    if (chain.axis_in_h) {
        const Vec3& p = chain.axis_in_h->line.point.v;
        const Vec3& d = chain.axis_in_h->line.direction.v;
        out += fmt::format("turntable axis in h: through ({:.4f}, {:.4f}, {:.4f}) mm along ({:.7f}, {:.7f}, {:.7f})\n",
                           p.x * 1e3, p.y * 1e3, p.z * 1e3, d.x, d.y, d.z);
    }
    if (chain.axis) {
        out += fmt::format("axis, 1 sigma in c: {:.3g} um across, {:.3g} mdeg\n", chain.axis->place_sigma * 1e6,
                           chain.axis->turn_sigma / kDegree * 1e3);
    }
    for (const MarkerFinding& f : chain.findings) {
        out += f.text() + "\n";
    }
    for (const std::string& note : chain.notes) {
        out += "note: " + note + "\n";
    }
    out += fmt::format("{:>12} {:>9} {:>8} {:>8} {:>10} {:>12} {:>10}\n", "view", "C deg", "markers", "rms um",
                       "sigma um", "sigma mdeg", "robot um");
    for (const ChainViewResult& v : chain.views) {
        out += fmt::format("{:>12} {:>9.3f} {:>8} {:>8.2f} {:>10.2f} {:>12.3f} {:>10}\n", v.name, v.turn / kDegree,
                           v.markers, v.rms * 1e6, v.place_sigma * 1e6, v.turn_sigma / kDegree * 1e3,
                           v.robot ? fmt::format("{:.1f}", v.robot_off * 1e6) : "");
    }
    return out;
}

std::string chain_svg(const ChainResult& chain, const std::string& title) {
    const Map map(chain);
    Svg svg(kSide, map.height());
    svg.rect(0.0, 0.0, kSide, map.height(), "page");
    svg.text(kInset, 28.0, title, "title");
    svg.text(kInset, 50.0,
             fmt::format("{} markers in {} views, seen along the table's axis; arrows: what is left of each sighting, "
                         "{:.0f} times as long (rms {:.1f} um)",
                         chain.markers.size(), chain.views.size(), kArrow, chain.rms * 1e6),
             "small");
    if (chain.axis) {
        const double x = map.x(chain.axis->point);
        const double y = map.y(chain.axis->point);
        svg.line(x - 9.0, y, x + 9.0, y, "axis");
        svg.line(x, y - 9.0, x, y + 9.0, "axis");
        svg.text(x + 11.0, y - 5.0, "axis", "small");
    }
    for (const ChainMarkerResult& m : chain.markers) {
        svg.open_group(fmt::format("marker {}: seen {} times, 1 sigma {:.1f} um, rms {:.1f} um{}", m.id, m.seen,
                                   sigma_um(m), m.rms * 1e6, m.turns ? ", turns with the table" : ""));
        svg.circle(map.x(m.place), map.y(m.place), m.turns ? 2.0 : 3.5, m.turns ? "burn" : "datum");
        if (!m.turns) {
            svg.text(map.x(m.place) + 6.0, map.y(m.place) - 5.0, std::to_string(m.id), "small");
        }
        svg.close_group();
    }
    for (const ChainResidual& r : chain.residuals) {
        const Vec3 tip = r.place + kArrow * r.residual;
        svg.open_group(fmt::format("marker {} in {}: {:.1f} um{}", r.id, r.view.empty() ? "h" : r.view,
                                   1e6 * norm(r.residual), r.used ? "" : ", left out"));
        if (r.used) {
            svg.line(map.x(r.place), map.y(r.place), map.x(tip), map.y(tip), "arrow");
        } else {
            svg.circle(map.x(r.place), map.y(r.place), 7.0, "lost");
        }
        svg.close_group();
    }
    return svg.finish();
}

void write_chain_files(const ChainWords& words, const ChainResult& chain) {
    if (!words.map.empty()) {
        write_target(words.map, marker_map(chain, "map of " + words.scan_set));
    }
    if (!words.svg.empty()) {
        write_text_file(words.svg, chain_svg(chain, words.scan_set));
    }
}

}  // namespace sc::host::cli
