// SPDX-License-Identifier: Apache-2.0
#include "host/cli/all_run.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "host/bridge/errors.hpp"
#include "host/bridge/stop.hpp"
#include "host/calibration/axis_map_fit.hpp"
#include "host/calibration/galvo_model.hpp"
#include "host/calibration/hand_eye.hpp"
#include "host/calibration/rigid_fit.hpp"
#include "host/calibration/transforms.hpp"
#include "host/cli/all_steps.hpp"
#include "host/cli/calibrate_run.hpp"
#include "host/cli/lag_run.hpp"
#include "host/cli/plate_run.hpp"
#include "host/cli/pointing_run.hpp"
#include "host/cli/scribe_run.hpp"
#include "host/cli/triple_head_run.hpp"
#include "host/cli/y_sensor_run.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr const char* kWorld = "boards/sim/world/default/world.toml";
constexpr double kMobileAcross = 10.0;  ///< um: a person's pointing where the option says 0

/// Covariance of a shift along y that all markers have in common.
void add_focus(Covariance<6>& covariance, double sigma) { covariance.at[4][4] += sigma * sigma; }

class Chain {
public:
    explicit Chain(const AllOptions& options) : options_(options), seed_(std::to_string(options.seed)) {}

    AllOutcome run() {
        begin();
        step("axes", [this](const auto& folder) { return axes(folder); });
        step("hand-eye", [this](const auto& folder) { return hand_eye(folder); });
        step("plate", [this](const auto& folder) { return left_out("plate") ? mobile(folder) : plate(folder); });
        step("table", [this](const auto& folder) { return table(folder); });
        step("lag", [this](const auto& folder) { return lag(folder); });
        step("y-sensor", [this](const auto& folder) { return y_sensor(folder); });
        step("triple-head", [this](const auto& folder) { return triple_head(folder); });
        AllOutcome out;
        out.file = options_.out / "calibration.toml";
        static_cast<void>(write_calibration(out.file, set_));
        out.set = set_;
        if (options_.verify) {
            out.faces = verify(out.file);
        }
        out.steps = std::move(said_);
        return out;
    }

private:
    [[nodiscard]] bool left_out(const char* what) const { return std::ranges::count(options_.without, what) > 0; }
    [[nodiscard]] std::filesystem::path folder_of(const std::string& name) const { return options_.out / name; }

    /// The options are kept, so that no call goes on with what another one began.
    void begin() {
        for (const std::string& word : options_.without) {
            if (std::ranges::count(leavable(), word) == 0) {
                throw InputError({.file = {},
                                  .problem = "no such step to leave out",
                                  .value = word,
                                  .action = "choose axes, references, plate, axis, lag, y-sensor or triple-head"});
            }
        }
        make_folder(options_.out);
        const Json asked{{"seed", options_.seed},
                         {"sigma_um", options_.sigma_um},
                         {"pointing_um", options_.pointing_um},
                         {"robot_bias_mm", options_.robot_bias_mm},
                         {"across", options_.across},
                         {"up", options_.up},
                         {"without", options_.without}};
        const std::filesystem::path file = options_.out / "options.json";
        if (std::filesystem::exists(file)) {
            if (Json::parse(read_text_file(file), nullptr, false) != asked) {
                throw InputError({.file = file.string(),
                                  .problem = "this folder belongs to a run with other options",
                                  .value = {},
                                  .action = "name another folder, or give the same options to go on"});
            }
        } else {
            write_text_file(file, asked.dump(2) + "\n");
        }
        set_.id = "cell-" + seed_;
        set_.time = now_text();
    }

    /// A step that is done has left its set and what it said.
    template <class Work>
    void step(const std::string& name, const Work& work) {
        ++number_;
        if (stop_requested()) {
            throw Interrupted();
        }
        const std::filesystem::path folder = folder_of(name);
        const std::filesystem::path done = folder / "calibration.toml";
        if (std::filesystem::exists(done)) {
            set_ = read_calibration(done);
            said_[name] = Json::parse(read_text_file(folder / "report.json"));
            options_.say(fmt::format("{} of 6, {}: done before", number_, name));
            return;
        }
        std::filesystem::create_directories(folder);
        options_.say(fmt::format("{} of 6, {}", number_, name));
        const Json report = work(folder);
        said_[name] = report;
        write_text_file(folder / "report.json", report.dump(2) + "\n");
        static_cast<void>(write_calibration(done, set_));
        // Read back: the next step starts from the same numbers whether it follows at once or later.
        set_ = read_calibration(done);
        options_.say("  " + report.value("text", std::string()));
    }

    [[nodiscard]] std::vector<std::string> words(const char* what, const std::filesystem::path& out,
                                                 const char* world = nullptr) const {
        std::vector<std::string> list{what,
                                      "--seed",
                                      seed_,
                                      "--out",
                                      out.string(),
                                      "--sigma-um",
                                      fmt::format("{}", options_.sigma_um),
                                      "--robot-bias-mm",
                                      fmt::format("{}", options_.robot_bias_mm)};
        if (world != nullptr) {
            list.insert(list.end(), {"--world", in_project(world).string()});
        }
        return list;
    }

    Json axes(const std::filesystem::path& folder) {
        if (left_out("axes")) {
            return {{"text", "left out: the axes are taken as true"}};
        }
        const std::filesystem::path file = folder / "axes.csv";
        survey(words("axes", file, kWorld));
        const FitQuality q = fit_axes(set_, reference_machine(), read_axes_points(file), file);
        set_.axes->provenance.parents = {"axes.csv"};
        return {{"text", fmt::format("axes: {} places, {:.2f} um rms before, {:.2f} um after", q.points,
                                     q.before_rms * 1e6, q.residual_rms * 1e6)},
                {"points", q.points},
                {"residual_rms_um", q.residual_rms * 1e6},
                {"worst_sigma_um", q.worst_sigma * 1e6}};
    }

    Json hand_eye(const std::filesystem::path& folder) {
        survey(words("fixed", folder));
        HandEyeOptions options;
        options.noise.fit = true;
        options.find_wrong = true;
        const HandEyeResult result = calibrate_hand_eye(
            folder / "robot.csv",
            pair_views(read_poses(folder / "robot.csv"), read_marker_views(folder / "markers.csv")), options);
        set_.transforms.push_back({.id = "f_from_c",
                                   .rotation = result.f_from_c.rotation,
                                   .translation = result.f_from_c.translation,
                                   .covariance = result.covariance,
                                   .provenance = {.parents = {"robot.csv", "markers.csv"},
                                                  .residual_rms = result.scatter_rms,
                                                  .time = now_text(),
                                                  .note = {}}});
        return {{"text",
                 fmt::format("f_from_c: 1 sigma {:.2f} mdeg, {:.1f} um; the target scatters by {:.3f} mm rms",
                             result.turn_sigma / kDegree * 1e3, result.place_sigma * 1e6, result.scatter_rms * 1e3)},
                {"turn_sigma_mdeg", result.turn_sigma / kDegree * 1e3},
                {"place_sigma_um", result.place_sigma * 1e6},
                {"scatter_rms_mm", result.scatter_rms * 1e3}};
    }

    Json plate(const std::filesystem::path& folder) {
        PlateOptionsAsked asked;
        asked.seed = options_.seed;
        asked.sigma_um = options_.sigma_um;
        asked.across = options_.across;
        asked.up = options_.up;
        burn_steps(asked, set_, folder);
        const std::filesystem::path seen = folder / "seen/crosses.csv";
        const PlateFit fit = fit_plate_crosses(seen, plate_sights(folder / "plan.csv", seen));
        set_ = with_plate(set_, fit, "seen/crosses.csv");
        return {
            {"text", fmt::format("h_from_c: 1 sigma {:.2f} mdeg, {:.2f} um at the crosses; galvo known to {:.2f} um; "
                                 "{} crosses, {} left out, {:.2f} um rms",
                                 fit.turn_sigma / kDegree * 1e3, fit.place_sigma * 1e6, fit.field_sigma * 1e6,
                                 fit.crosses.size(), fit.wrong().size(), fit.rms * 1e6)},
            {"turn_sigma_mdeg", fit.turn_sigma / kDegree * 1e3},
            {"place_sigma_um", fit.place_sigma * 1e6},
            {"focus_sigma_um", fit.focus_sigma * 1e6},
            {"field_sigma_um", fit.field_sigma * 1e6},
            {"rms_um", fit.rms * 1e6},
            {"waist_um", fit.mark.waist * 1e6},
            {"rayleigh_mm", fit.mark.rayleigh * 1e3},
            {"wrong", fit.wrong()}};
    }

    /// In place of the plate: a person points at the mobile target.
    Json mobile(const std::filesystem::path& folder) {
        PointingOptions asked;
        asked.out = folder;
        asked.seed = options_.seed;
        asked.markers = 0;
        asked.pointing_um = options_.pointing_um > 0.0 ? options_.pointing_um : kMobileAcross;
        const std::filesystem::path axes = folder_of("hand-eye") / "calibration.toml";
        asked.calibration = axes;
        const PointingOutcome pointed = run_pointing(asked);
        const std::filesystem::path c_csv = folder / "mobile/markers.csv";
        const RigidFit fit = fit_rigid(c_csv, read_marker_views(pointed.h_csv).views.front().markers,
                                       read_marker_views(c_csv).views.front().markers);
        TransformRecord record{.id = "h_from_c",
                               .rotation = fit.rotation,
                               .translation = fit.translation,
                               .covariance = fit.covariance,
                               .provenance = {.parents = {"axes", "h.csv", "mobile/markers.csv"},
                                              .residual_rms = fit.rms,
                                              .time = now_text(),
                                              .note = "pointed at by a person; the focus is common to all markers"}};
        add_focus(record.covariance, pointed.focus_sigma);
        set_.transforms.push_back(std::move(record));
        // c is where the sensor saw this target.
        return {{"text", fmt::format("h_from_c from {} pointed markers: {:.2f} um rms; focus known to {:.1f} um",
                                     fit.markers.size(), fit.rms * 1e6, pointed.focus_sigma * 1e6)},
                {"rms_um", fit.rms * 1e6},
                {"focus_sigma_um", pointed.focus_sigma * 1e6}};
    }

    /// Where c was defined: the view of what gave h_from_c.
    [[nodiscard]] std::filesystem::path first_view() const {
        return folder_of("plate") / (left_out("plate") ? "mobile" : "seen");
    }

    [[nodiscard]] Stitch stitch(const std::vector<std::filesystem::path>& more) const {
        std::vector<std::filesystem::path> folders{first_view()};
        folders.insert(folders.end(), more.begin(), more.end());
        if (left_out("references")) {
            const TransformRecord& record = *set_.find("f_from_c");
            return stitch_by_robot(folders, {record.rotation, record.translation});
        }
        return stitch_folders(folders);
    }

    Json table(const std::filesystem::path& folder) {
        survey(words("ring", folder / "ring"));
        const std::vector<std::string> list = words("table", folder / "markers", kWorld);
        survey(list);
        const Stitch placed = stitch({folder / "ring", folder / "markers"});
        const TurntableFit fit =
            fit_turntable(folder / "markers/markers.csv", markers_in_c(folder / "markers", placed));
        if (left_out("axis")) {
            set_.turntable =
                AxisRecord{.line = {{{-0.250, -0.470, 0.0}}, {{0.0, 0.0, 1.0}}},
                           .covariance = {},
                           .provenance = {.parents = {"drawing"}, .residual_rms = 0.0, .time = now_text(), .note = {}}};
            for (std::size_t i = 0; i < 4; ++i) {
                set_.turntable->covariance.at[i][i] = 1e-8;
            }
            return {{"text", "left out: the axis is where the drawing has it"}};
        }
        set_.turntable = axis_record(fit, set_);
        set_.turntable->provenance.parents.emplace_back("markers/markers.csv");
        set_.turntable->provenance.time = now_text();
        return {{"text", fmt::format("axis: 1 sigma {:.2f} mdeg, {:.2f} um in c; {} angles, {:.2f} um rms; references "
                                     "{:.2f} um rms over {} views",
                                     fit.turn_sigma() / kDegree * 1e3, fit.place_sigma() * 1e6, fit.views.size(),
                                     fit.rms * 1e6, placed.rms * 1e6, placed.views.size())},
                {"turn_sigma_mdeg", fit.turn_sigma() / kDegree * 1e3},
                {"place_sigma_um", fit.place_sigma() * 1e6},
                {"rms_um", fit.rms * 1e6},
                {"references_rms_um", placed.rms * 1e6},
                {"views", placed.views.size()}};
    }

    Json lag(const std::filesystem::path& folder) {
        if (left_out("lag") || left_out("plate")) {
            return {{"text", "left out: the mirrors follow as the machine states"}};
        }
        GalvoLagOptions asked;
        asked.seed = options_.seed;
        asked.sigma_um = options_.sigma_um;
        burn_lag_plate(asked, set_, galvo_field_of(set_), folder);
        measure_lag_plate(folder, options_.sigma_um, options_.seed, folder / "measured.csv");
        GalvoLagOutcome found = fit_lag_plate(folder / "plan.csv", folder / "measured.csv", set_);
        set_ = std::move(found.set);
        return {{"text", fmt::format("lag: {:.2f} us, {:.0f} Hz, damping {:.3f}; {:.2f} um rms",
                                     static_cast<double>(found.fit.lag.latency_ns) * 1e-3,
                                     found.fit.lag.natural_frequency.si(), found.fit.lag.damping, found.fit.rms * 1e6)},
                {"rms_um", found.fit.rms * 1e6}};
    }

    Json y_sensor(const std::filesystem::path& folder) {
        if (left_out("y-sensor") || left_out("plate") || left_out("references")) {
            return {{"text", "left out: no y_sensor in the set"}};
        }
        YSensorOptions asked;
        asked.out = folder;
        asked.seed = options_.seed;
        asked.sigma_um = options_.sigma_um;
        const SensorRayFit fit = scan_simulated_roof(asked, set_, options_.out);
        set_.y_sensor = y_sensor_record(fit, now_text());
        return {
            {"text", fmt::format("Y sensor: x {:.3f}, z {:.3f} mm beside the focus, zero {:.4f} mm; {} readings, "
                                 "{:.1f} um rms",
                                 fit.origin.x * 1e3, fit.origin.z * 1e3, fit.zero * 1e3, fit.readings, fit.rms * 1e6)},
            {"rms_um", fit.rms * 1e6},
            {"readings", fit.readings}};
    }

    Json triple_head(const std::filesystem::path& folder) {
        if (left_out("triple-head") || left_out("plate") || left_out("references")) {
            return {{"text", "left out: no triple_head in the set"}};
        }
        TripleHeadOptions asked;
        asked.out = folder;
        asked.seed = options_.seed;
        asked.sigma_um = options_.sigma_um;
        const TripleHeadFit fit = scan_simulated_sides(asked, set_, options_.out);
        put_triple_head(set_, fit, now_text());
        double rms = 0.0;
        double sigma = 0.0;
        for (const SensorRayFit& ray : fit.rays) {
            rms = std::max(rms, ray.rms);
            sigma = std::max({sigma, std::sqrt(ray.covariance.at[0][0]), std::sqrt(ray.covariance.at[1][1])});
        }
        return {{"text", fmt::format("triple head: beams known across to {:.0f} um; {} readings each, {:.0f} um rms",
                                     sigma * 1e6, fit.rays[0].readings, rms * 1e6)},
                {"rms_um", rms * 1e6},
                {"across_sigma_um", sigma * 1e6}};
    }

    std::vector<FaceFigures> verify(const std::filesystem::path& calibration) {
        const std::filesystem::path folder = folder_of("verify");
        std::filesystem::create_directories(folder);
        options_.say("36 markers on four faces: measured, converted, scribed");
        const std::filesystem::path part = folder / "part";
        survey(words("workpiece", part, kWorld));
        const Stitch placed = stitch({folder_of("table") / "ring", folder_of("table") / "markers", part});
        std::vector<FaceMarker> markers;
        for (const MarkerView& view : markers_in_c(part, placed)) {
            for (const SeenMarker& marker : view.markers) {
                // As it stands at the view's angle, tied to the table at C = 0.
                const Point<frame::H> now = h_from_c(set_) * Point<frame::C>{marker.place};
                const int face = marker.id / 100;
                markers.push_back(
                    {90.0 * face, marker.id % 100, from_face(set_, now, -view.turn.value_or(0.0) / kDegree).v});
            }
        }
        write_marker_job(set_, calibration, markers, folder);
        survey({"judge", "--seed", seed_, "--world", (part / "world.toml").string(), "--measured",
                (folder / "measured.csv").string(), "--out", (folder / "table.csv").string()});
        ScribeOptions scribe;
        scribe.job = folder / "job.toml";
        scribe.link_options.world = part / "world.toml";
        scribe.link_options.out = folder / "run";
        scribe.link_options.seed = options_.seed;
        std::filesystem::remove_all(folder / "run");
        const ScribeOutcome scribed = run_scribe(scribe);
        if (scribed.failure) {
            throw CellError("the markers were not scribed: " + scribed.failure->message);
        }
        return figures(*scribed.report);
    }

    static FaceFigures figures_of(double face, std::vector<double> axis, std::vector<double> place) {
        FaceFigures out{.face_deg = face, .markers = place.size(), .axis_95 = 0.0, .axis_max = 0.0, .place_max = 0.0};
        if (!place.empty()) {
            std::ranges::sort(axis);
            const auto at = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(axis.size()))) - 1;
            out.axis_95 = axis[at] * 1e6;
            out.axis_max = axis.back() * 1e6;
            out.place_max = *std::ranges::max_element(place) * 1e6;
        }
        return out;
    }

    static std::vector<FaceFigures> figures(const Report& report) {
        std::vector<FaceFigures> out;
        std::vector<double> all_axis;
        std::vector<double> all_place;
        for (const FaceAccuracy& face : report.accuracy.faces) {
            std::vector<double> axis;
            std::vector<double> place;
            for (const PointAccuracy& point : face.points) {
                const Vec3& d = point.deviation;
                axis.insert(axis.end(), {std::abs(d.x), std::abs(d.y), std::abs(d.z)});
                place.push_back(norm(d));
            }
            all_axis.insert(all_axis.end(), axis.begin(), axis.end());
            all_place.insert(all_place.end(), place.begin(), place.end());
            out.push_back(figures_of(face.face_deg, std::move(axis), std::move(place)));
        }
        out.push_back(figures_of(-1.0, std::move(all_axis), std::move(all_place)));
        return out;
    }

    const AllOptions& options_;
    std::string seed_;
    CalibrationSet set_;
    Json said_ = Json::object();
    int number_ = 0;
};

}  // namespace

const std::vector<std::string>& leavable() {
    static const std::vector<std::string> names{"axes", "references", "plate",      "axis",
                                                "lag",  "y-sensor",   "triple-head"};
    return names;
}

AllOutcome run_all(const AllOptions& options) { return Chain(options).run(); }

}  // namespace sc::host::cli
