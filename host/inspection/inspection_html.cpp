// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/inspection_html.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "host/formats/text.hpp"
#include "host/inspection/allowance_map.hpp"
#include "host/inspection/inspection_drawings.hpp"

namespace sc::host {

namespace {

constexpr double kMm = 1e3;
constexpr std::array<const char*, 6> kMotions{"x", "y", "z", "rx", "ry", "rz"};

constexpr const char* kHead = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Inspection of a blank</title><style>
body{font:14px/1.45 system-ui,sans-serif;max-width:1180px;margin:24px auto;padding:0 16px;color:#222}
h1{font-size:22px}h2{font-size:17px;margin:28px 0 8px;border-bottom:1px solid #ccc}
table{border-collapse:collapse}td,th{padding:2px 10px;text-align:right;border-bottom:1px solid #e4e4e4}
td:first-child,th:first-child{text-align:left}.ok{color:#157015}.bad{color:#b3261e;font-weight:600}
figure{display:inline-block;margin:6px 14px 6px 0}figcaption{font-size:13px;color:#555}
svg text{font-size:11px;fill:#444}.axis{stroke:#444}.asked{stroke:#000;stroke-dasharray:3 2}
.lack{fill:#3c66d6}.more{fill:#d9683c}.before{fill:#b9b9b9}.after{fill:#d9683c}
.cad{stroke:#999;fill:none}.run{stroke:#157015;stroke-width:1.6;fill:none}.gap{stroke:#b3261e;stroke-dasharray:4 3}
input{width:64px}canvas{border:1px solid #ccc;touch-action:none;cursor:grab;max-width:100%}
.scale .bar{display:inline-block;width:180px;height:10px;margin:0 8px;
background:linear-gradient(90deg,#1e46e6,#cddcf0,#ebe1cd,#dc281e)}
</style></head><body>
)";

std::string cell(const std::string& text) { return "<td>" + escaped(text) + "</td>"; }
std::string mm(double metres, int digits = 3) { return fixed(kMm * metres, digits); }
std::string place(const Vec3& v) { return mm(v.x, 2) + " " + mm(v.y, 2) + " " + mm(v.z, 2); }

std::string header_table(const Inspection& i, const ReportHeader& header) {
    std::string out = "<table>";
    const auto row = [&](const std::string& name, const std::string& value) {
        out += "<tr>" + cell(name) + cell(value) + "</tr>";
    };
    for (const auto& [name, value] : header) {
        row(name, value.empty() ? "not stated" : value);
    }
    row("points", std::to_string(i.points));
    row("aligned by", std::string(name_of(i.aligned_by)));
    row("spread of the points used", mm(i.fit.sigma, 4) + " mm, " + std::to_string(i.fit.rejected) + " of " +
                                         std::to_string(i.fit.used + i.fit.rejected) + " rejected");
    row("CAD surface seen", fixed(100.0 * i.coverage, 1) + " %");
    return out + "</table>";
}

std::string faces_table(const AllowanceReport& before, const AllowanceReport* after) {
    std::string out =
        "<table><tr><th>face</th><th>asked</th><th>min</th><th>mean</th><th>max</th><th>sigma</th><th>points</th>";
    out += after != nullptr ? "<th>min after</th><th>mean after</th><th>sigma after</th>" : "";
    out += "<th></th></tr>";
    for (std::size_t k = 0; k < before.faces.size(); ++k) {
        const FaceAllowance& face = before.faces[k];
        const FaceAllowance& last = after != nullptr ? after->faces[k] : face;
        out += "<tr>" + cell(face.id) + cell(mm(face.least_asked)) + cell(mm(face.least)) + cell(mm(face.mean)) +
               cell(mm(face.most)) + cell(mm(face.sigma)) + cell(std::to_string(face.count));
        if (after != nullptr) {
            out += cell(mm(last.least)) + cell(mm(last.mean)) + cell(mm(last.sigma));
        }
        const char* word = last.count == 0 ? "not seen" : (last.enough() ? "ok" : "lacking");
        out += std::string("<td class=\"") + (last.enough() ? "ok" : "bad") + "\">" + word + "</td></tr>";
    }
    return out + "</table>";
}

std::string worst_table(const AllowanceReport& report) {
    std::string out = "<table><tr><th>face</th><th>place (w), mm</th><th>allowance, mm</th><th>less asked</th></tr>";
    for (const FaceAllowance& face : report.faces) {
        for (const WorstPlace& worst : face.worst) {
            out += "<tr>" + cell(face.id) + cell(place(worst.place)) + cell(mm(worst.allowance)) +
                   cell(mm(worst.allowance - face.least_asked)) + "</tr>";
        }
    }
    return out + "</table>";
}

std::string proof(const Inspection& i, const Borrowing& b) {
    const auto deg = [](double radians) { return fixed(radians * 180.0 / std::numbers::pi, 5); };
    std::string out =
        "<p>shift " + mm(b.along[0], 4) + ", " + mm(b.along[1], 4) + ", " + mm(b.along[2], 4) + " mm; turn " +
        deg(b.along[3]) + ", " + deg(b.along[4]) + ", " + deg(b.along[5]) +
        " degrees about the middle of the model. Smallest margin " + mm(b.margin_before, 4) + " → " + mm(b.margin, 4) +
        " mm, variance within the faces " + fixed(b.variance_before * kMm * kMm, 5) + " → " +
        fixed(b.variance * kMm * kMm, 5) + " mm². " +
        "These places stop it. Their multipliers sum to 1 with those of the bounds, and their directions and "
        "moments, so weighted, cancel out: no motion raises the smallest margin. What is left of that "
        "(KKT residual): " +
        decimal(b.kkt_residual) + ".</p>";
    out +=
        "<table><tr><th>face</th><th>multiplier</th><th>place (w), mm</th><th>direction</th><th>margin, mm</th></tr>";
    for (const ActivePoint& a : b.active) {
        out += "<tr>" + cell(i.plan.groups[a.group].id + (a.upper ? " (most)" : "")) + cell(fixed(a.multiplier, 6)) +
               cell(place(a.place)) +
               cell(fixed(a.direction.x, 4) + " " + fixed(a.direction.y, 4) + " " + fixed(a.direction.z, 4)) +
               cell(mm(a.margin, 5)) + "</tr>";
    }
    for (const ActiveBound& bound : b.bounds) {
        out += "<tr>" + cell(std::string("bound of ") + kMotions[bound.motion] + (bound.upper ? " (+)" : " (-)")) +
               cell(fixed(bound.multiplier, 6)) + cell("") + cell("") + cell("") + "</tr>";
    }
    return out + "</table>";
}

std::string uncertainty_table(const Uncertainty& uncertainty) {
    std::string out = "<table><tr><th>of</th><th>source</th><th>one standard deviation, mm</th><th>from</th></tr>";
    const auto rows = [&](const std::string& of, const std::vector<UncertaintySource>& sources) {
        for (const UncertaintySource& source : sources) {
            out += "<tr>" + cell(of) + cell(source.name) + cell(mm(source.sigma, 4)) + cell(source.from) + "</tr>";
        }
        if (!sources.empty()) {
            out += "<tr>" + cell(of) + "<th>together, k = 2</th>" + cell("\u00b1" + mm(expanded(sources), 4)) +
                   cell("") + "</tr>";
        }
    };
    rows("allowance at a place", uncertainty.allowance);
    rows("place of a datum line", uncertainty.lines);
    return out +
           "</table><p>What a whole scan has in common (its scale, how its views were joined) is not in the scan "
           "and not in this table.</p>";
}

}  // namespace

std::string inspection_html(const Inspection& i, const DistanceField& field, const ReportHeader& header,
                            const Uncertainty& uncertainty) {
    const AllowanceReport* after = i.after ? &*i.after : nullptr;
    const AllowanceReport& last = after != nullptr ? *after : i.before;
    std::string out = kHead;
    out += std::string("<h1>Inspection of a blank: <span class=\"") + (last.enough() ? "ok" : "bad") + "\">" +
           (last.enough() ? "metal everywhere" : "not enough metal") + "</span></h1>";
    out += header_table(i, header);
    for (const std::string& note : i.notes) {
        out += "<p>Note: " + escaped(note) + ".</p>";
    }
    out += "<h2>Allowance of each face, mm</h2>" + faces_table(i.before, after);
    if (i.borrowing && i.borrowing->margin < 0.0) {
        out += "<p class=\"bad\">No placement within the bounds gives every face what it asks; " +
               mm(-i.borrowing->margin) + " mm is lacking. These faces fight:";
        for (const Conflict& c : conflicts(i)) {
            out += " " + escaped(c.id) + " (share " + fixed(c.share, 3) + ", asks " + mm(c.asked) + ", gets " +
                   mm(c.best) + ")";
        }
        out += "</p>";
    }
    out +=
        "<h2>Allowance map</h2><p>Drag to turn, wheel to zoom. Grey: as cast. Green: datum lines. "
        "Numbers below the map shift the blank and colour it anew.</p>" +
        map_html(i, field, 1e-3);
    out += "<h2>Opposite sides, mean allowance in mm (grey before, coloured after)</h2>" + sides_svg(i.before, after);
    out += "<h2>Histograms</h2>";
    for (std::size_t k = 0; k < i.before.faces.size(); ++k) {
        if (i.before.faces[k].count > 0) {
            out += histogram_svg(i.before.faces[k], after != nullptr ? &after->faces[k] : nullptr);
        }
    }
    out += "<h2>Worst places</h2>" + worst_table(last);
    if (i.borrowing) {
        out += "<h2>Borrowing and its proof</h2>" + proof(i, *i.borrowing);
    }
    out += "<h2>Uncertainty</h2>" + uncertainty_table(uncertainty);
    if (!i.lines.empty()) {
        out += "<h2>Datum lines on the measured surface (grey: CAD model)</h2>";
        for (const DatumLine& line : i.lines) {
            out += section_svg(line, field.mesh());
        }
    }
    return out + "</body></html>\n";
}

}  // namespace sc::host
