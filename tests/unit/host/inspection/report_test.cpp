// SPDX-License-Identifier: Apache-2.0
#include <regex>
#include <stack>
#include <string>

#include <gtest/gtest.h>

#include "host/formats/scan.hpp"
#include "host/formats/text.hpp"
#include "host/inspection/inspection_html.hpp"
#include "tests/bench/line_truth.hpp"
#include "tests/unit/host/inspection/shapes.hpp"

namespace sc::host::test {
namespace {

/// Every element that is opened is closed, in order.
std::string unbalanced(const std::string& html) {
    std::stack<std::string> open;
    const std::regex tag("<(/?)([a-z0-9]+)([^>]*?)(/?)>");
    std::string text = std::regex_replace(html, std::regex("<script>[^]*?</script>"), "");
    text = std::regex_replace(text, std::regex("<style>[^]*?</style>"), "");
    for (std::sregex_iterator it(text.begin(), text.end(), tag), end; it != end; ++it) {
        const std::string name = (*it)[2];
        if ((*it)[4].length() > 0 || name == "meta" || name == "input" || name == "br") {
            continue;
        }
        if ((*it)[1].length() == 0) {
            open.push(name);
        } else if (open.empty() || open.top() != name) {
            return "</" + name + ">";
        } else {
            open.pop();
        }
    }
    return open.empty() ? "" : "<" + open.top() + ">";
}

std::size_t count(const std::string& text, const std::string& what) {
    std::size_t n = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) {
        ++n;
    }
    return n;
}

TEST(InspectionHtml, TellsWhatWasFoundAndNeedsNothingElse) {
    const DistanceField field(read_mesh(casting("finished.stl")).mesh);
    const Part part = read_part(casting("part-infeasible.toml"));
    const PointCloud cloud = read_scan(casting("scan.ply")).cloud;
    InspectionRequest request;
    request.start = true_placement(casting("truth_pose.txt"));
    request.lines = true;
    const Inspection inspection = inspect(field, cloud.points, &part, request);
    const std::string html = inspection_html(inspection, field, {{"operator", "A <b> & C"}, {"serial number", "7"}},
                                             uncertainty_of(inspection, field, nullptr));
    EXPECT_EQ(unbalanced(html), "");
    EXPECT_EQ(html.find("://"), std::string::npos) << "nothing from outside";
    EXPECT_NE(html.find("A &lt;b&gt; &amp; C"), std::string::npos);
    EXPECT_NE(html.find("not enough metal"), std::string::npos);
    EXPECT_NE(html.find("These faces fight: "), std::string::npos);
    EXPECT_EQ(count(html, "<figure>"), inspection.before.faces.size() + inspection.lines.size());
    EXPECT_EQ(count(html, "class=\"run\""), inspection.lines[0].cut.runs.size() + inspection.lines[1].cut.runs.size() +
                                                inspection.lines[2].cut.runs.size());
    for (const ActivePoint& active : inspection.borrowing->active) {
        EXPECT_NE(html.find(fixed(active.multiplier, 6)), std::string::npos);
    }
    EXPECT_NE(html.find("together, k = 2"), std::string::npos);
    EXPECT_LT(html.size(), 1'500'000U);
}

}  // namespace
}  // namespace sc::host::test
