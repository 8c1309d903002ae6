// SPDX-License-Identifier: Apache-2.0
// scribecell-stereo-peer DIR: OpenCV's calibrateCamera and stereoCalibrate, five coefficients, on the sets of
// `scribecell-rig stereo` (or any set_NNNN/left.csv and right.csv of the same form; --size WxH). Writes DIR/opencv.csv,
// a row a set: rms of a coordinate, both cameras, right_from_left. Shares no code with the project's estimator.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

namespace {

namespace fs = std::filesystem;

struct Point {
    cv::Point3f board;
    cv::Point2f seen;
};
using View = std::map<std::pair<int, int>, Point>;

/// view,row,col,X_mm,Y_mm,u_px,v_px
std::map<std::string, View> views_of(const fs::path& file) {
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    std::map<std::string, View> out;
    while (std::getline(in, line)) {
        std::istringstream text(line);
        std::vector<std::string> f;
        for (std::string field; std::getline(text, field, ',');) {
            f.push_back(field);
        }
        out[f.at(0)][{std::stoi(f.at(1)), std::stoi(f.at(2))}] = {{std::stof(f.at(3)), std::stof(f.at(4)), 0.0F},
                                                                  {std::stof(f.at(5)), std::stof(f.at(6))}};
    }
    return out;
}

void solve_set(const fs::path& folder, const std::string& name, const cv::Size& size, std::FILE* out) {
    const auto left = views_of(folder / name / "left.csv");
    const auto right = views_of(folder / name / "right.csv");
    std::vector<std::vector<cv::Point3f>> board;
    std::vector<std::vector<cv::Point2f>> seen_left;
    std::vector<std::vector<cv::Point2f>> seen_right;
    for (const auto& [view, points] : left) {
        const auto other = right.find(view);
        if (other == right.end()) {
            continue;
        }
        board.emplace_back();
        seen_left.emplace_back();
        seen_right.emplace_back();
        for (const auto& [cell, point] : points) {
            const auto twin = other->second.find(cell);
            if (twin != other->second.end()) {
                board.back().push_back(point.board);
                seen_left.back().push_back(point.seen);
                seen_right.back().push_back(twin->second.seen);
            }
        }
    }
    cv::Mat k[2];
    cv::Mat d[2];
    std::vector<cv::Mat> turns;
    std::vector<cv::Mat> places;
    cv::calibrateCamera(board, seen_left, size, k[0], d[0], turns, places);
    cv::calibrateCamera(board, seen_right, size, k[1], d[1], turns, places);
    cv::Mat r;
    cv::Mat t;
    cv::Mat e;
    cv::Mat f;
    // rms of a point's distance; both coordinates share it.
    const double rms = cv::stereoCalibrate(
        board, seen_left, seen_right, k[0], d[0], k[1], d[1], size, r, t, e, f, cv::CALIB_USE_INTRINSIC_GUESS,
        cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-9));
    std::fprintf(out, "%s,%.15g", name.c_str(), rms / std::sqrt(2.0));
    for (int c = 0; c < 2; ++c) {
        std::fprintf(out, ",%.9f,%.9f,%.9f,%.9f", k[c].at<double>(0, 0), k[c].at<double>(1, 1), k[c].at<double>(0, 2),
                     k[c].at<double>(1, 2));
        for (int i = 0; i < 5; ++i) {
            std::fprintf(out, ",%.9f", d[c].at<double>(i));
        }
    }
    for (int i = 0; i < 3; ++i) {
        std::fprintf(out, ",%.9f", t.at<double>(i));
    }
    for (int i = 0; i < 9; ++i) {
        std::fprintf(out, ",%.12f", r.at<double>(i / 3, i % 3));
    }
    std::fputc('\n', out);
}

}  // namespace

int main(int argc, char** argv) {
    cv::Size size(1280, 960);
    if (!(argc == 2 || (argc == 4 && std::strcmp(argv[2], "--size") == 0 &&
                        std::sscanf(argv[3], "%dx%d", &size.width, &size.height) == 2))) {
        std::fputs("use: scribecell-stereo-peer DIR [--size WxH]\n", stderr);
        return 2;
    }
    const fs::path folder = argv[1];
    std::FILE* out = std::fopen((folder / "opencv.csv").c_str(), "w");
    if (out == nullptr) {
        std::fprintf(stderr, "scribecell-stereo-peer: %s cannot be written\n", (folder / "opencv.csv").c_str());
        return 1;
    }
    std::fputs("set,rms_px", out);
    for (const char* side : {"l", "r"}) {
        for (const char* name : {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"}) {
            std::fprintf(out, ",%s_%s", name, side);
        }
    }
    std::fputs(",x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33\n", out);
    for (int i = 1;; ++i) {
        char name[16];
        std::snprintf(name, sizeof name, "set_%04d", i);
        if (!fs::exists(folder / name)) {
            break;
        }
        solve_set(folder, name, size, out);
    }
    return std::fclose(out) == 0 ? 0 : 1;
}
