// SPDX-License-Identifier: Apache-2.0
// scribecell-hand-eye-peer DIR: OpenCV's five hand-eye methods on the sets of scribecell-rig. Writes DIR/opencv.csv, a
// row a set and method with f_from_c. The target's pose in each view is a rigid fit (Kabsch) of its markers to those of
// the first view, as users of these methods do it. Shares no code with the project's estimator.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

namespace {

namespace fs = std::filesystem;

std::vector<std::vector<double>> rows_of(const fs::path& file) {
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    std::vector<std::vector<double>> out;
    while (std::getline(in, line)) {
        std::istringstream fields(line);
        std::vector<double> row;
        for (std::string field; std::getline(fields, field, ',');) {
            row.push_back(std::stod(field));
        }
        out.push_back(row);
    }
    return out;
}

using Cloud = std::map<int, cv::Vec3d>;

/// to = r from + t.
void kabsch(const Cloud& to, const Cloud& from, cv::Mat& r, cv::Mat& t) {
    cv::Vec3d mean_to(0.0, 0.0, 0.0);
    cv::Vec3d mean_from(0.0, 0.0, 0.0);
    const double n = static_cast<double>(to.size());
    for (const auto& [id, place] : to) {
        mean_to += place * (1.0 / n);
        mean_from += from.at(id) * (1.0 / n);
    }
    cv::Matx33d sum = cv::Matx33d::zeros();
    for (const auto& [id, place] : to) {
        sum += (place - mean_to) * (from.at(id) - mean_from).t();
    }
    cv::Mat w;
    cv::Mat u;
    cv::Mat vt;
    cv::SVD::compute(cv::Mat(sum), w, u, vt);
    cv::Mat sign = cv::Mat::eye(3, 3, CV_64F);
    sign.at<double>(2, 2) = cv::determinant(u * vt) < 0.0 ? -1.0 : 1.0;
    r = u * sign * vt;
    t = cv::Mat(mean_to) - r * cv::Mat(mean_from);
}

void solve_set(const fs::path& folder, const std::string& name, std::FILE* out) {
    std::vector<cv::Mat> robot_r;
    std::vector<cv::Mat> robot_t;
    for (const auto& row : rows_of(folder / "robot.csv")) {
        robot_t.push_back((cv::Mat_<double>(3, 1) << row[1], row[2], row[3]));
        robot_r.push_back(
            (cv::Mat_<double>(3, 3) << row[4], row[5], row[6], row[7], row[8], row[9], row[10], row[11], row[12]));
    }
    std::vector<Cloud> views(robot_r.size());
    for (const auto& row : rows_of(folder / "target.csv")) {
        views[static_cast<std::size_t>(row[0]) - 1][static_cast<int>(row[1])] = {row[2], row[3], row[4]};
    }
    std::vector<cv::Mat> target_r(views.size());
    std::vector<cv::Mat> target_t(views.size());
    for (std::size_t i = 0; i < views.size(); ++i) {
        kabsch(views[i], views[0], target_r[i], target_t[i]);
    }
    constexpr const char* kNames[] = {"tsai", "park", "horaud", "andreff", "daniilidis"};
    for (int method = 0; method < 5; ++method) {
        cv::Mat r;
        cv::Mat t;
        cv::calibrateHandEye(robot_r, robot_t, target_r, target_t, r, t,
                             static_cast<cv::HandEyeCalibrationMethod>(method));
        if (!cv::checkRange(r) || !cv::checkRange(t)) {
            r = cv::Mat::eye(3, 3, CV_64F);
            t = cv::Mat::zeros(3, 1, CV_64F);
        }
        std::fprintf(out, "%s,%s", name.c_str(), kNames[method]);
        for (int i = 0; i < 3; ++i) {
            std::fprintf(out, ",%.10f", t.at<double>(i));
        }
        for (int i = 0; i < 9; ++i) {
            std::fprintf(out, ",%.13f", r.at<double>(i / 3, i % 3));
        }
        std::fputc('\n', out);
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("use: scribecell-hand-eye-peer DIR\n", stderr);
        return 2;
    }
    const fs::path folder = argv[1];
    std::FILE* out = std::fopen((folder / "opencv.csv").c_str(), "w");
    if (out == nullptr) {
        std::fprintf(stderr, "scribecell-hand-eye-peer: %s cannot be written\n", (folder / "opencv.csv").c_str());
        return 1;
    }
    std::fputs("set,method,x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33\n", out);
    for (int i = 1;; ++i) {
        char name[16];
        std::snprintf(name, sizeof name, "set_%04d", i);
        if (!fs::exists(folder / name)) {
            break;
        }
        solve_set(folder / name, name, out);
    }
    std::fclose(out);
    return 0;
}
