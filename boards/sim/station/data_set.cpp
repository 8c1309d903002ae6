// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/station/data_set.hpp"

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <stdexcept>

#include "boards/sim/station/picture.hpp"

namespace sc::sim {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::array kPlates{0.26, 0.3, 0.34};
constexpr double kPlateSigma = 5e-6;          ///< metres, of a plate's height
constexpr double kRegistrationSigma = 10e-6;  ///< of its dots
constexpr int kPlateReadings = 200;
constexpr std::array kKnownAngles{57.5, 62.5, 67.5, 72.5, 77.5, 82.5, 87.5, 92.5};
constexpr int kKnownReadings = 100;
constexpr double kKnownSigma = 0.003 * kDegree;
constexpr double kKnownPlace = 10e-6;
constexpr double kYaw = 3.0;  ///< degrees either side
constexpr double kRailStep = 0.6;

// The camera: above the head, looks along the beams.
constexpr int kWidth = 1024;
constexpr int kHeight = 896;
constexpr double kFocal = 4000.0;     ///< px
constexpr double kCameraBack = 0.35;  ///< metres behind z = 0
constexpr double kDot = 8e-3;         ///< metres, diameter

std::string text_of(const char* format, ...) __attribute__((format(printf, 1, 2)));
// NOLINTNEXTLINE(cert-dcl50-cpp): a printf of the project, checked by the compiler.
std::string text_of(const char* format, ...) {
    std::array<char, 512> line{};
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(line.data(), line.size(), format, arguments);
    va_end(arguments);
    return line.data();
}

void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out(file, std::ios::binary);
    out << text;
    out.close();
    if (!out) {
        throw std::runtime_error(file.string() + " cannot be written");
    }
}

struct Camera {
    Mat3 cam_from_d;
    Vec3 place;

    /// Column and row.
    [[nodiscard]] std::array<double, 2> see(const Vec3& p) const {
        const Vec3 c = cam_from_d * (p - place);
        return {0.5 * kWidth + kFocal * c.x / c.z, 0.5 * kHeight + kFocal * c.y / c.z};
    }
};

Camera make_camera(double side, Random& random) {
    Vec3 tilt;
    tilt.x = 1.5 * kDegree * normal_draw(random);
    tilt.y = 1.5 * kDegree * normal_draw(random);
    tilt.z = 1.0 * kDegree * normal_draw(random);
    // So placed that it still looks at the middle of the head's beams.
    const Vec3 middle{0.5 * side, side * std::sqrt(3.0) / 6.0, 0.3};
    const Mat3 turn = rotation_about(tilt);
    return {turn, middle - turn.transposed() * Vec3{0.0, 0.0, 0.3 + kCameraBack}};
}

std::vector<std::array<double, 2>> dot_grid(double side) {
    std::vector<std::array<double, 2>> dots;
    for (int row = 0; row < 5; ++row) {
        for (int column = 0; column < 7; ++column) {
            dots.push_back(
                {0.5 * side + (column - 3) * 0.2 * side, side * std::sqrt(3.0) / 6.0 + (row - 2) * 0.2 * side});
        }
    }
    return dots;
}

class DataSet {
public:
    DataSet(std::filesystem::path folder, const DataSetOptions& options)
        : folder_(std::move(folder)),
          options_(options),
          random_(options.seed),
          head_(made_head(options.side, options.errors, random_)) {}

    void write() {
        write_stand();
        write_known();
        write_stations();
        write_truth_of_head();
    }

private:
    std::string reading_row(const std::string& station, const TrueHead& head, const TruePlane& in_d) {
        std::array<double, 3> d{};
        for (std::size_t i = 0; i < 3; ++i) {
            d[i] = reading_of(head.beams[i], in_d, options_.sigma, random_) * 1e3;
        }
        return text_of("%s,%.4f,%.4f,%.4f", station.c_str(), d[0], d[1], d[2]);
    }

    void picture_of_plate(std::size_t plate, double height, const Camera& camera, const std::array<double, 2>& shift) {
        const std::string name = "plate_" + std::to_string(plate + 1);
        Picture dots(kWidth, kHeight, 0.75);
        add_gradient(dots, 0.15, 0.7);
        const double half = 0.5 * kDot;
        for (const auto& dot : dot_grid(options_.side)) {
            const Vec3 p{dot[0] + shift[0], dot[1] + shift[1], height};
            const auto c = camera.see(p);
            const auto a = camera.see(p + Vec3{half, 0.0, 0.0});
            const auto b = camera.see(p + Vec3{0.0, half, 0.0});
            add_disc(dots, c, {a[0] - c[0], a[1] - c[1]}, {b[0] - c[0], b[1] - c[1]}, 0.1);
        }
        write_picture(folder_ / (name + "_dots.pgm"), dots, 0.01, random_);
        for (std::size_t i = 0; i < 3; ++i) {
            Picture picture(kWidth, kHeight, 0.08);
            add_gradient(picture, 0.05, 2.1);
            SpotLook look;
            look.centre = camera.see(spot_on(head_.beams[i], plate_in_d(height)));
            look.waist = 14.0;
            look.peak = 1.4;
            look.speckle = 0.15;
            add_spot(picture, look, random_);
            write_picture(folder_ / (name + "_spot_" + std::to_string(i + 1) + ".pgm"), picture, 0.01, random_);
        }
    }

    void write_stand() {
        const Camera camera = make_camera(options_.side, random_);
        const TrueHead drawn = drawn_head(options_.side);
        std::string text =
            "format = \"scribecell-stand\"\nversion = 1\nid = \"stand\"\n"
            "time = \"2026-01-31T12:00:00Z\"\nrange_mm = [50.0, 2000.0]\nsigma_um = 100.0\n"
            "height_sigma_um = 5.0\n";
        for (std::size_t i = 0; i < 3; ++i) {
            text += text_of("\n[[sensor]]\nid = \"L%zu\"\norigin_mm = [%.4f, %.4f]\n", i + 1,
                            drawn.beams[i].origin.x * 1e3, drawn.beams[i].origin.y * 1e3);
        }
        std::string x;
        std::string y;
        for (const auto& dot : dot_grid(options_.side)) {
            x += text_of("%s%.6f", x.empty() ? "" : ", ", dot[0] * 1e3);
            y += text_of("%s%.6f", y.empty() ? "" : ", ", dot[1] * 1e3);
        }
        text += "\n[dots]\nx_mm = [" + x + "]\ny_mm = [" + y + "]\ndiameter_mm = 8.0\nregistration_um = 10.0\n";
        text += "\n[mount]\narm_mm = 40.0\npitch_mm = 0.5\nclockwise = \"positive\"\n";
        text += text_of(
            "\n[reference]\nrotation = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]\n"
            "translation_mm = [%.4f, %.4f, %.4f]\nsigma_deg = 0.2\nsigma_mm = 0.5\n",
            drawn.seat.x * 1e3, drawn.seat.y * 1e3, drawn.seat.z * 1e3);
        for (std::size_t plate = 0; plate < kPlates.size(); ++plate) {
            const double height = kPlates[plate] + kPlateSigma * normal_draw(random_);
            std::array<double, 2> shift{};
            shift[0] = kRegistrationSigma * normal_draw(random_);
            shift[1] = kRegistrationSigma * normal_draw(random_);
            const std::string name = "plate_" + std::to_string(plate + 1);
            if (options_.pictures) {
                picture_of_plate(plate, height, camera, shift);
            }
            std::string rows = "station,d1_mm,d2_mm,d3_mm\n";
            for (int k = 0; k < kPlateReadings; ++k) {
                rows += reading_row(name, head_, plate_in_d(height)) + "\n";
            }
            write_text(folder_ / (name + ".csv"), rows);
            text += text_of("\n[[height]]\nz_mm = %.4f\ndots = \"%s_dots.pgm\"\n", kPlates[plate] * 1e3, name.c_str());
            text +=
                text_of("spots = [\"%s_spot_1.pgm\", \"%s_spot_2.pgm\", \"%s_spot_3.pgm\"]\nreadings = \"%s.csv\"\n",
                        name.c_str(), name.c_str(), name.c_str(), name.c_str());
        }
        write_text(folder_ / "stand.toml", text);
    }

    void write_known() {
        const auto at = middle_in_r(options_.side);
        std::string known = "station,angle_deg,u_deg,yaw_deg,u_yaw_deg,distance_mm,u_mm\n";
        std::string rows = "station,d1_mm,d2_mm,d3_mm\n";
        int sign = 1;
        for (const double angle_deg : kKnownAngles) {
            const std::string station = text_of("known_%.1f", angle_deg);
            const double angle = angle_deg * kDegree + kKnownSigma * normal_draw(random_);
            const double yaw = sign * 4.0 * kDegree + kKnownSigma * normal_draw(random_);
            const double distance = options_.distance + kKnownPlace * normal_draw(random_);
            const TruePlane plane = plane_in_d(head_, face_in_r(angle, yaw, distance, at[0], at[1]));
            for (int k = 0; k < kKnownReadings; ++k) {
                rows += reading_row(station, head_, plane) + "\n";
            }
            known += text_of("%s,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f\n", station.c_str(), angle_deg, kKnownSigma / kDegree,
                             sign * 4.0, kKnownSigma / kDegree, options_.distance * 1e3, kKnownPlace * 1e3);
            sign = -sign;
        }
        write_text(folder_ / "known.csv", known);
        write_text(folder_ / "known_readings.csv", rows);
    }

    void write_stations() {
        const auto at = middle_in_r(options_.side);
        std::uniform_real_distribution<double> even(-1.0, 1.0);
        std::string truth = "station,angle_deg,yaw_deg,distance_mm\n";
        std::string rows = "station,rail_mm,d1_mm,d2_mm,d3_mm\n";
        int number = 0;
        for (int repeat = 0; repeat < options_.repeats; ++repeat) {
            for (const double angle_deg : options_.angles_deg) {
                const std::string station = text_of("s%04d_%g", ++number, angle_deg);
                const double yaw_deg = kYaw * even(random_);
                const double distance = options_.distance + 0.01 * even(random_);
                const TrueHead head = reseated(head_, options_.seat_angle, options_.seat_place, random_);
                const TruePlane plane =
                    plane_in_d(head, face_in_r(angle_deg * kDegree, yaw_deg * kDegree, distance, at[0], at[1]));
                for (int k = 0; k < options_.readings; ++k) {
                    const std::string row = reading_row(station, head, plane);
                    const std::size_t comma = row.find(',');
                    rows +=
                        row.substr(0, comma) + text_of(",%.1f", number * kRailStep * 1e3) + row.substr(comma) + "\n";
                }
                truth += text_of("%s,%.6f,%.6f,%.6f\n", station.c_str(), angle_deg, yaw_deg, distance * 1e3);
            }
        }
        write_text(folder_ / "stations.csv", rows);
        write_text(folder_ / "truth.csv", truth);
    }

    void write_truth_of_head() {
        std::string text = "{\"beams\": [";
        for (std::size_t i = 0; i < 3; ++i) {
            const TrueBeam& b = head_.beams[i];
            text += text_of(
                "%s\n  {\"origin_mm\": [%.6f, %.6f], \"tilt_mrad\": [%.6f, %.6f], \"zero_mm\": %.6f, "
                "\"gain_ppm\": %.3f}",
                i == 0 ? "" : ",", b.origin.x * 1e3, b.origin.y * 1e3, b.direction.x / b.direction.z * 1e3,
                b.direction.y / b.direction.z * 1e3, b.zero * 1e3, b.gain * 1e6);
        }
        text += text_of("],\n \"seat_mm\": [%.6f, %.6f, %.6f],\n \"d_from_r\": [", head_.seat.x * 1e3,
                        head_.seat.y * 1e3, head_.seat.z * 1e3);
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3& row = head_.d_from_r.row[i];
            text += text_of("%s[%.12f, %.12f, %.12f]", i == 0 ? "" : ", ", row.x, row.y, row.z);
        }
        write_text(folder_ / "head_truth.json", text + "]}\n");
    }

    std::filesystem::path folder_;
    DataSetOptions options_;
    Random random_;
    TrueHead head_;
};

}  // namespace

void write_data_set(const std::filesystem::path& folder, const DataSetOptions& options) {
    std::filesystem::create_directories(folder);
    DataSet(folder, options).write();
}

void write_spots(const std::filesystem::path& folder, int count, std::uint64_t seed) {
    std::filesystem::create_directories(folder);
    Random random(seed);
    std::uniform_real_distribution<double> even;
    std::string truth = "picture,x_px,y_px,waist_px,stretch,peak,speckle,background\n";
    for (int i = 0; i < count; ++i) {
        SpotLook look;
        look.waist = 12.0 + 18.0 * even(random);
        look.stretch = 1.0 / std::cos(40.0 * kDegree * even(random));
        look.heading = std::numbers::pi * even(random);
        look.peak = 0.5 + 2.5 * even(random);
        look.speckle = 0.05 + 0.15 * even(random);
        look.grain = 0.8 + 0.7 * even(random);
        const double background = 0.08 + 0.12 * even(random);  // so much that nothing is darker than black
        const double rise = 0.1 * even(random);
        const double heading = 2.0 * std::numbers::pi * even(random);
        look.centre[0] = 128.0 + 20.0 * (even(random) - 0.5);
        look.centre[1] = 128.0 + 20.0 * (even(random) - 0.5);
        Picture picture(256, 256, background);
        add_gradient(picture, rise, heading);
        add_spot(picture, look, random);
        const std::string name = text_of("spot_%04d.pgm", i + 1);
        write_picture(folder / name, picture, 0.01, random);
        truth += text_of("%s,%.6f,%.6f,%.4f,%.4f,%.4f,%.4f,%.4f\n", name.c_str(), look.centre[0], look.centre[1],
                         look.waist, look.stretch, look.peak, look.speckle, background);
    }
    write_text(folder / "truth.csv", truth);
}

}  // namespace sc::sim
