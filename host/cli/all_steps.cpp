// SPDX-License-Identifier: Apache-2.0
#include "host/cli/all_steps.hpp"

#include <array>
#include <cmath>
#include <set>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/calibration/transforms.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/registration/chain.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kSurvey = "scribecell-survey";

std::string view_name(const std::filesystem::path& folder, const std::string& view) {
    return folder.filename().string() + "/" + view;
}

Eigen::Vector3d vector_of(const Vec3& v) { return {v.x, v.y, v.z}; }

/// By the small turn w about the origin and the small shift t: w × v + t, as a matrix of (w, t).
Eigen::Matrix<double, 3, 6> moved(const Vec3& v, bool shifts) {
    Eigen::Matrix<double, 3, 6> out = Eigen::Matrix<double, 3, 6>::Zero();
    out.leftCols<3>() << 0.0, v.z, -v.y, -v.z, 0.0, v.x, v.y, -v.x, 0.0;
    if (shifts) {
        out.rightCols<3>().setIdentity();
    }
    return out;
}

}  // namespace

void survey(const std::vector<std::string>& words) {
    const ProgramOutput output = run_program(required_program(kSurvey), words);
    if (output.exit_code != 0) {
        throw CellError(fmt::format("{} {} ended with {}", kSurvey, words.front(), output.exit_code));
    }
}

const Rigid<frame::C, frame::C>& Stitch::of(const std::string& view) const {
    const auto found = views.find(view);
    if (found == views.end()) {
        throw InputError({.file = {},
                          .problem = left_out.empty() ? "a view that has no place in c"
                                                      : fmt::format("{}", fmt::join(left_out, "; ")),
                          .value = view,
                          .action = "give it three reference markers or more that other views have"});
    }
    return found->second;
}

Stitch stitch_folders(const std::vector<std::filesystem::path>& folders) {
    ChainInput input;
    input.file = folders.front() / "references.csv";
    for (const auto& folder : folders) {
        for (MarkerView& view : read_marker_views(folder / "references.csv").views) {
            view.view = view_name(folder, view.view);
            view.turn.reset();
            for (const SeenMarker& marker : view.markers) {
                input.still.insert(marker.id);
            }
            input.views.push_back({.seen = std::move(view), .b_from_f = {}});
        }
    }
    const ChainResult chain = fit_chain(input);
    Stitch out{.views = {}, .rms = chain.rms, .left_out = chain.notes};
    for (const ChainViewResult& view : chain.views) {
        out.views[view.name] = {view.rotation, view.translation};
    }
    return out;
}

Stitch stitch_by_robot(const std::vector<std::filesystem::path>& folders, const Rigid<frame::F, frame::C>& f_from_c) {
    Stitch out;
    std::optional<Rigid<frame::C, frame::B>> c_from_b;
    for (const auto& folder : folders) {
        for (const NamedPose& pose : read_poses(folder / "robot.csv").poses) {
            const Rigid<frame::B, frame::F> b_from_f{pose.rotation, pose.translation};
            const Rigid<frame::B, frame::C> b_from_view = b_from_f * f_from_c;
            if (!c_from_b) {
                c_from_b = b_from_view.inverse();
            }
            out.views[view_name(folder, pose.view)] = *c_from_b * b_from_view;
        }
    }
    return out;
}

std::vector<MarkerView> markers_in_c(const std::filesystem::path& folder, const Stitch& stitch) {
    std::vector<MarkerView> views = read_marker_views(folder / "markers.csv").views;
    for (MarkerView& view : views) {
        const Rigid<frame::C, frame::C>& c_from_view = stitch.of(view_name(folder, view.view));
        for (SeenMarker& marker : view.markers) {
            marker.place = (c_from_view * Point<frame::C>{marker.place}).v;
        }
    }
    return views;
}

AxisRecord axis_record(const TurntableFit& fit, const CalibrationSet& set) {
    const Rigid<frame::H, frame::C> to_h = h_from_c(set);
    AxisRecord out;
    out.line.point = to_h * Point<frame::C>{fit.point};
    Vec3 direction = to_h.rotation * fit.direction;
    const double sign = direction.z < 0.0 ? -1.0 : 1.0;
    direction = sign * direction;
    out.line.direction.v = direction;
    // To the plane z = point.z: what moves the axis along itself does not count.
    Eigen::Matrix<double, 2, 3> onto_plane;
    onto_plane << 1.0, 0.0, -direction.x / direction.z, 0.0, 1.0, -direction.y / direction.z;
    Eigen::Matrix4d by_fit = Eigen::Matrix4d::Zero();
    for (int k = 0; k < 2; ++k) {
        const Eigen::Vector3d across = vector_of(to_h.rotation * fit.across[static_cast<std::size_t>(k)]);
        by_fit.block<2, 1>(0, k) = onto_plane * across;
        by_fit.block<2, 1>(2, 2 + k) = sign * across.head<2>();
    }
    Eigen::Matrix<double, 4, 6> by_pose;
    by_pose.topRows<2>() = onto_plane * moved(out.line.point.v, true);
    by_pose.bottomRows<2>() = moved(direction, false).topRows<2>();
    Eigen::Matrix4d of_fit;
    Eigen::Matrix<double, 6, 6> of_pose;
    const TransformRecord& record = *set.find("h_from_c");
    for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < 6; ++j) {
            const auto a = static_cast<Eigen::Index>(i);
            const auto b = static_cast<Eigen::Index>(j);
            of_pose(a, b) = record.covariance.at[i][j];
            if (i < 4 && j < 4) {
                of_fit(a, b) = fit.covariance.at[i][j];
            }
        }
    }
    const Eigen::Matrix4d sum = by_fit * of_fit * by_fit.transpose() + by_pose * of_pose * by_pose.transpose();
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
            const auto a = static_cast<Eigen::Index>(i);
            const auto b = static_cast<Eigen::Index>(j);
            out.covariance.at[i][j] = 0.5 * (sum(a, b) + sum(b, a));
        }
    }
    out.provenance.parents = {"h_from_c"};
    out.provenance.residual_rms = fit.rms;
    return out;
}

void write_marker_job(const CalibrationSet& set, const std::filesystem::path& calibration,
                      const std::vector<FaceMarker>& markers, const std::filesystem::path& folder) {
    std::map<double, std::string> points;
    std::string measured = "face_deg,no,mx,my,mz\n";
    for (const FaceMarker& marker : markers) {
        std::string& text = points.try_emplace(marker.face_deg, "no,x,y,z\n").first->second;
        const Vec3 c = 1e3 * marker.place;
        text += fmt::format("{},{:.6f},{:.6f},{:.6f}\n", marker.no, c.x, c.y, c.z);
        const Vec3 h = 1e3 * to_face(set, Point<frame::C>{marker.place}, marker.face_deg).v;
        measured += fmt::format("{},{},{:.6f},{:.6f},{:.6f}\n", marker.face_deg, marker.no, h.x, h.y, h.z);
    }
    std::string job = fmt::format(
        "# 36 markers on four faces, as they were measured in c.\nformat = \"scribecell-job\"\nversion = 1\n"
        "name = \"calibrate all\"\ntable = \"table.csv\"\ncalibration = \"{}\"\n\n[cross]\nsize_mm = 4.0\n"
        "actuator = \"axes\"\nspeed_mm_s = 60.0\npitch_um = 20.0\nenergy_uj = 300.0\npasses = 1\n",
        stored_path(folder / "job.toml", std::filesystem::absolute(calibration)));
    for (const auto& [face, text] : points) {
        const std::string file = fmt::format("face{:.0f}_c.csv", face);
        write_text_file(folder / file, text);
        job += fmt::format("\n[[face]]\nangle_deg = {:.1f}\nframe = \"c\"\npoints = \"{}\"\n", face, file);
    }
    write_text_file(folder / "measured.csv", measured);
    write_text_file(folder / "job.toml", job);
}

}  // namespace sc::host::cli
