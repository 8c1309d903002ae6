// SPDX-License-Identifier: Apache-2.0
#include "host/verification/report.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "host/verification/svg.hpp"
#include "ras3dm_run.hpp"

namespace sc::host {
namespace {

using synthetic::Ras3dmRun;

Report report_of(const Ras3dmRun& run) {
    const JobPlan plan = run.plan();
    Report report;
    report.burns = run.find(plan);
    report.accuracy = assess(report.burns, run.table, plan, run.header, run.calibration);
    report.run = {"ras3dm <test> & more", "0123456789abcdef", "armed", 26000, 61.5, 7.25, "ab12"};
    report.samples.ticks = 61500;
    return report;
}

Report shifted_report() {
    Ras3dmRun run;
    run.header.errors = {{"galvo.offset_x", 85.0, "um", "calibration: galvo field"},
                         {"turntable.runout", 0.5, "um", "none"}};
    run.error = [](const Vec3&) { return Vec3{50e-6, 0.0, 0.0}; };
    return report_of(run);
}

std::size_t count_of(const std::string& text, std::string_view part) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) {
        ++count;
    }
    return count;
}

TEST(ReportJson, HasTheKeysThatProgramsReadAndTheFigures) {
    const Report report = shifted_report();
    const auto json = report_json(report);
    EXPECT_EQ(json.at("state"), "armed");
    EXPECT_EQ(json.at("pulses"), 26000);
    EXPECT_EQ(json.at("limit_violations"), 0);
    EXPECT_EQ(json.at("cell_seconds"), 61.5);
    EXPECT_EQ(json.at("wall_seconds"), 7.25);
    EXPECT_EQ(json.at("command_trace_sha256"), "ab12");
    EXPECT_EQ(json.at("complete"), true);
    EXPECT_NEAR(json.at("max_command_error_um").get<double>(), 50.0, 0.02);
    ASSERT_EQ(json.at("faces").size(), 4U);
    for (std::size_t f = 0; f < 4; ++f) {
        const auto& face = json.at("faces")[f];
        const FaceAccuracy& source = report.accuracy.faces[f];
        EXPECT_EQ(face.at("face_deg"), source.face_deg);
        EXPECT_EQ(face.at("points"), 9);
        EXPECT_EQ(face.at("table").size(), 9U);
        EXPECT_NEAR(face.at("max").at("x_mm").get<double>(), 1e3 * source.found.max.x, 1e-6);
        EXPECT_NEAR(face.at("rms").at("z_mm").get<double>(), 1e3 * source.found.rms.z, 1e-6);
        EXPECT_NEAR(face.at("csv_max").at("y_mm").get<double>(), 1e3 * source.csv.max.y, 1e-6);
        EXPECT_NEAR(face.at("csv_rms").at("x_mm").get<double>(), 1e3 * source.csv.rms.x, 1e-6);
    }
    EXPECT_NEAR(json.at("found_errors").at("offset_x_um").at("value").get<double>(), 50.0, 0.01);
    EXPECT_EQ(json.at("datum_lines").size(), 4U);
    ASSERT_EQ(json.at("known_errors").size(), 2U);
    EXPECT_EQ(json.at("known_errors")[0].at("name"), "galvo.offset_x");
    EXPECT_NEAR(json.at("known_errors")[0].at("left").get<double>(),
                85.0 - 1e6 * Ras3dmRun{}.calibration.galvo->offset[0], 1e-9);
    EXPECT_TRUE(json.at("known_errors")[1].at("calibrated").is_null());
    EXPECT_EQ(nlohmann::ordered_json::parse(json.dump()), json);
}

TEST(ReportJson, ListsViolations) {
    Report report = shifted_report();
    report.samples.limit_violations = 7;
    report.samples.first = {{Breach::jerk, 42, -1, "z", 210.0, 200.0}};
    const auto json = report_json(report);
    EXPECT_EQ(json.at("limit_violations"), 7);
    EXPECT_EQ(json.at("violations")[0].at("rule"), "jerk");
    EXPECT_EQ(json.at("violations")[0].at("tick"), 42);
}

TEST(ReportJson, FiguresCanBeRecomputedFromItsOwnTable) {
    const auto json = report_json(shifted_report());
    for (const auto& face : json.at("faces")) {
        double most = 0.0;
        for (const auto& point : face.at("table")) {
            const double off = point.at("found_mm")[0].get<double>() - point.at("true_mm")[0].get<double>();
            most = std::max(most, std::abs(off));
        }
        EXPECT_NEAR(most, face.at("max").at("x_mm").get<double>(), 2.1e-6);
    }
}

TEST(ReportText, ShowsFourFacesWithTheirFigures) {
    const std::string text = report_text(shifted_report());
    for (const char* part :
         {"0° surface", "90° surface", "180° surface", "270° surface", "found on the surface, 9 points",
          "the table alone", "known errors", "Datum lines", "offset_x", "galvo.offset_x", "limit violations: 0",
          "36 crosses, 4 lines", "cell time 61.5 s, wall time 7.2", "largest command error: 50.0",
          "all that was planned was found"}) {
        EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
    }
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = text.find('\n', at);
        EXPECT_LE(end - at, 140U) << text.substr(at, end - at);
        at = end + 1;
    }
}

TEST(ReportText, SaysWhatIsMissing) {
    Ras3dmRun run;
    run.skip = [](const PlannedPath& path) { return path.face_deg == 180.0 && path.marker == 4; };
    const std::string text = report_text(report_of(run));
    EXPECT_NE(text.find("not found: marker 4"), std::string::npos);
    EXPECT_NE(text.find("NOT COMPLETE"), std::string::npos);
}

TEST(ReportSvg, DrawsEveryStrokeNumberAndArrow) {
    const std::string svg = report_svg(shifted_report());
    EXPECT_EQ(count_of(svg, "class=\"burn\""), 72U);
    EXPECT_EQ(count_of(svg, "class=\"datum\""), 4U);
    EXPECT_EQ(count_of(svg, "<title>marker "), 36U);
    EXPECT_EQ(count_of(svg, "class=\"no\""), 36U);
    EXPECT_GE(count_of(svg, "class=\"arrow\""), 36U);
    EXPECT_EQ(count_of(svg, "° surface"), 4U);
    EXPECT_EQ(svg.find("<script"), std::string::npos);
    EXPECT_EQ(svg.find("href"), std::string::npos);
    EXPECT_NE(svg.find("ras3dm &lt;test&gt; &amp; more"), std::string::npos);
}

TEST(ReportSvg, OpensAndClosesEveryElement) {
    const std::string svg = report_svg(shifted_report());
    std::vector<std::string> open;
    for (std::size_t at = svg.find('<'); at != std::string::npos; at = svg.find('<', at + 1)) {
        const std::size_t end = svg.find('>', at);
        ASSERT_NE(end, std::string::npos);
        const std::string tag = svg.substr(at + 1, end - at - 1);
        if (tag[0] == '?' || tag.back() == '/') {
            continue;
        }
        if (tag[0] == '/') {
            ASSERT_FALSE(open.empty());
            EXPECT_EQ(open.back(), tag.substr(1));
            open.pop_back();
        } else {
            open.push_back(tag.substr(0, tag.find(' ')));
        }
    }
    EXPECT_TRUE(open.empty());
}

TEST(ReportSvg, NothingIsDrawnOutsideThePicture) {
    const std::string svg = report_svg(shifted_report());
    const std::size_t box = svg.find("viewBox=\"0 0 ");
    double width = 0.0;
    double height = 0.0;
    ASSERT_EQ(std::sscanf(svg.c_str() + box, "viewBox=\"0 0 %lf %lf\"", &width, &height), 2);
    std::size_t lines = 0;
    for (std::size_t at = svg.find("<line"); at != std::string::npos; at = svg.find("<line", at + 1)) {
        double x1 = 0.0;
        double y1 = 0.0;
        double x2 = 0.0;
        double y2 = 0.0;
        ASSERT_EQ(std::sscanf(svg.c_str() + svg.find("x1", at), "x1=\"%lf\" y1=\"%lf\" x2=\"%lf\" y2=\"%lf\"", &x1, &y1,
                              &x2, &y2),
                  4);
        EXPECT_GE(std::min({x1, y1, x2, y2}), 0.0);
        EXPECT_LE(std::max(x1, x2), width);
        EXPECT_LE(std::max(y1, y2), height);
        ++lines;
    }
    EXPECT_GT(lines, 100U);
}

TEST(ReportSvg, EmptyReportIsStillAPicture) { EXPECT_NE(report_svg(Report{}).find("</svg>"), std::string::npos); }

TEST(Svg, EscapesTextAndDropsControlCharacters) {
    Svg svg(10, 10);
    svg.text(1, 1, "a<b>&\"c\"\x01", "small");
    EXPECT_NE(svg.finish().find("a&lt;b&gt;&amp;&quot;c&quot; </text>"), std::string::npos);
}

}  // namespace
}  // namespace sc::host
