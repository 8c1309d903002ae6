// SPDX-License-Identifier: Apache-2.0
// The report of scribecell inspect in a browser: its map is drawn, turns, and can be shifted.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/sim/host/cli/program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;

/// Does what a hand would do, and writes what came of it into the page's title.
constexpr const char* kHand = R"JS(<script>
window.addEventListener('load',function(){
var c=document.getElementById('map'),o={},text=function(id){return document.getElementById(id).textContent;};
function sum(){var d=c.getContext('2d').getImageData(0,0,c.width,c.height).data,s=0,i;for(i=0;i<d.length;i++)s=(s*31+d[i])>>>0;return s;}
function pointer(type,x,y){c.dispatchEvent(new PointerEvent(type,{clientX:x,clientY:y,pointerId:1}));}
c.setPointerCapture=function(){};
o.drawn=+c.dataset.drawn;o.first=sum();o.least=+text('least');o.at=text('exact');
pointer('pointerdown',100,100);pointer('pointermove',160,130);pointer('pointerup',160,130);o.turned=sum();
c.dispatchEvent(new WheelEvent('wheel',{deltaY:200}));o.zoomed=sum();
var e=document.querySelectorAll('#shift input');e[2].value='0.2';e[2].dispatchEvent(new Event('input'));
o.shifted=sum();o.shifted_least=+text('least');o.exact=text('exact');
e[2].value='0';e[2].dispatchEvent(new Event('input'));o.back=sum();
document.title=JSON.stringify(o);});
</script>)JS";

nlohmann::json in_browser(const fs::path& page, const fs::path& folder) {
    Program browser("/usr/bin/chromium",
                    {"--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
                     "--disable-background-networking", "--disable-component-update", "--disable-sync",
                     "--user-data-dir=" + (folder / "browser").string(), "--dump-dom", "--virtual-time-budget=20000",
                     "file://" + page.string()});
    EXPECT_EQ(browser.wait(), 0) << browser.err();
    const std::string& dom = browser.out();
    const std::size_t begin = dom.find("<title>") + 7;
    return nlohmann::json::parse(dom.substr(begin, dom.find("</title>") - begin), nullptr, false);
}

nlohmann::json inspect(const std::vector<std::string>& more) {
    const fs::path data = fs::path(SC_TEST_DATA) / "casting-blank";
    std::vector<std::string> words{"inspect",
                                   "--cad",
                                   (data / "finished.stl").string(),
                                   "--scan",
                                   (data / "scan.ply").string(),
                                   "--part",
                                   std::string(SC_SOURCE_DIR) + "/examples/casting/part.toml",
                                   "--json"};
    words.insert(words.end(), more.begin(), more.end());
    Program program("scribecell", words);
    EXPECT_LE(program.wait(), 1) << program.err();  // 1: not enough metal, before borrowing
    return nlohmann::json::parse(program.out());
}

TEST(InspectReport, IsDrawnTurnsAndShiftsInABrowser) {
    const fs::path folder = fresh_folder();
    const fs::path page = folder / "report.html";
    const auto report = inspect({"--report", page.string(), "--lines", (folder / "lines").string()});
    write_file(page, replaced(read_file(page), "</body>", std::string(kHand) + "</body>"));
    const auto seen = in_browser(page, folder);
    ASSERT_TRUE(seen.is_object()) << "the page's script failed";
    EXPECT_GT(seen["drawn"].get<int>(), 20'000);
    EXPECT_NE(seen["first"], seen["turned"]);
    EXPECT_NE(seen["turned"], seen["zoomed"]);
    EXPECT_NE(seen["zoomed"], seen["shifted"]) << "a shift colours the map anew";
    EXPECT_EQ(seen["zoomed"], seen["back"]);
    // One point in some twenty is drawn: its least margin is no less than the exact one, and not much more.
    const double exact = report["after"]["least_margin_mm"];
    EXPECT_GE(seen["least"].get<double>(), exact - 0.002);
    EXPECT_LE(seen["least"].get<double>(), exact + 0.1);
    // What the page says to run for the exact answer gives one that agrees with the page's.
    const auto shifted = inspect({"--no-borrow", seen["at"].get<std::string>()});
    EXPECT_NEAR(shifted["what_if"]["least_margin_mm"].get<double>(), exact, 0.002);
    const double said = inspect({"--no-borrow", seen["exact"].get<std::string>()})["what_if"]["least_margin_mm"];
    EXPECT_GE(seen["shifted_least"].get<double>(), said - 0.004);
    EXPECT_LE(seen["shifted_least"].get<double>(), said + 0.1);
    EXPECT_LT(said, exact - 0.05) << "the optimum was left";
    fs::remove_all(folder);
}

TEST(InspectReport, ColouredPointsSayWhatTheReportSays) {
    const fs::path folder = fresh_folder();
    const auto report = inspect({"--map", (folder / "map.ply").string(), "--pictures", (folder / "pictures").string(),
                                 "--lines", (folder / "lines").string(), "--calibration",
                                 std::string(SC_SOURCE_DIR) + "/examples/ras3dm/calibration.toml"});
    const std::string ply = read_file(folder / "map.ply");
    const std::size_t body = ply.find("end_header\n") + 11;
    constexpr std::size_t kRecord = 4 * 4 + 3;
    ASSERT_EQ((ply.size() - body) % kRecord, 0U);
    float least = 1e9F;
    for (std::size_t at = body; at < ply.size(); at += kRecord) {
        float margin = 0.0F;
        std::copy_n(ply.data() + at + 15, sizeof margin, reinterpret_cast<char*>(&margin));
        least = std::min(least, margin);
        const auto byte = [&](std::size_t k) { return static_cast<int>(static_cast<unsigned char>(ply[at + 12 + k])); };
        ASSERT_TRUE(margin > 0.1F ? byte(0) > byte(2) : margin > -0.1F || byte(2) > byte(0))
            << "warm is more, cool is less";
    }
    EXPECT_NEAR(least, report["after"]["least_margin_mm"].get<double>(), 1e-4);
    std::size_t pictures = 0;
    for (const auto& file : fs::directory_iterator(folder / "pictures")) {
        const std::string svg = read_file(file.path());
        EXPECT_TRUE(svg.starts_with("<?xml") && svg.ends_with("</svg>\n")) << file.path();
        EXPECT_EQ(svg.find("<figure"), std::string::npos);
        ++pictures;
    }
    EXPECT_EQ(pictures, 2 + report["after"]["faces"].size() + report["lines"].size());
    // Warm for what is to spare, which is nearly all of this part, and grey for what is as cast.
    const std::string map = read_file(folder / "pictures/map.svg");
    EXPECT_NE(map.find("rgb(200,200,200)"), std::string::npos);
    EXPECT_NE(map.find("rgb(220,40,30)"), std::string::npos);
    const auto& lines = report["uncertainty"]["lines"];
    ASSERT_EQ(lines["sources"].size(), 3U);
    double squares = 0.0;
    for (const auto& source : lines["sources"]) {
        EXPECT_GT(source["sigma_mm"].get<double>(), 0.0);
        squares += source["sigma_mm"].get<double>() * source["sigma_mm"].get<double>();
    }
    EXPECT_NEAR(lines["expanded_mm"].get<double>(), 2.0 * std::sqrt(squares), 1e-5);
    fs::remove_all(folder);
}

}  // namespace
}  // namespace sc::test
