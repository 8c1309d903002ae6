// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/inspection_drawings.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr double kMm = 1e3;
constexpr std::array<const char*, 6> kSides{"+X", "-X", "+Y", "-Y", "+Z", "-Z"};
constexpr std::size_t kMapPoints = 24000;
constexpr double kGreyPoints = 16000.0;
constexpr std::uint8_t kGrey = 254;  ///< surfaces that ask for nothing
constexpr std::uint8_t kLine = 255;

std::string num(double value) { return fixed(value, 2); }

std::string rect(double x, double y, double width, double height, const char* style) {
    return "<rect x=\"" + num(x) + "\" y=\"" + num(y) + "\" width=\"" + num(width) + "\" height=\"" + num(height) +
           "\" class=\"" + style + "\"/>";
}
std::string label(double x, double y, const std::string& text, const char* anchor = "middle") {
    return "<text x=\"" + num(x) + "\" y=\"" + num(y) + "\" text-anchor=\"" + anchor + "\">" + escaped(text) +
           "</text>";
}
std::string stroke(double x1, double y1, double x2, double y2, const char* style) {
    return "<line x1=\"" + num(x1) + "\" y1=\"" + num(y1) + "\" x2=\"" + num(x2) + "\" y2=\"" + num(y2) +
           "\" class=\"" + style + "\"/>";
}
std::string svg(double width, double height, const std::string& body) {
    return "<svg viewBox=\"0 0 " + num(width) + " " + num(height) + "\" width=\"" + num(width) + "\" role=\"img\">" +
           body + "</svg>";
}

/// Coordinates within a plane, and the box about what is drawn.
class Flat {
public:
    explicit Flat(const Plane& plane) {
        const Vec3 n = plane.normal;
        const Vec3 other = std::abs(n.z) < 0.8 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
        const Vec3 across = cross(other, n);
        u_ = (1.0 / norm(across)) * across;
        v_ = cross(n, u_);
    }
    void take(const Vec3& p) {
        const auto [x, y] = raw(p);
        low_ = {std::min(low_[0], x), std::min(low_[1], y)};
        high_ = {std::max(high_[0], x), std::max(high_[1], y)};
    }
    [[nodiscard]] double scale() const { return kWide / std::max(high_[0] - low_[0], 1e-6); }
    [[nodiscard]] std::array<double, 2> at(const Vec3& p) const {
        const auto [x, y] = raw(p);
        return {20.0 + scale() * (x - low_[0]), 20.0 + scale() * (high_[1] - y)};
    }
    [[nodiscard]] double height() const { return 40.0 + scale() * (high_[1] - low_[1]); }
    static constexpr double kWide = 520.0;

private:
    [[nodiscard]] std::array<double, 2> raw(const Vec3& p) const { return {dot(p, u_), dot(p, v_)}; }
    Vec3 u_;
    Vec3 v_;
    std::array<double, 2> low_{1e9, 1e9};
    std::array<double, 2> high_{-1e9, -1e9};
};

std::string path_of(const Flat& flat, std::span<const LinePlace> places, bool closed) {
    std::string out = "<path class=\"run\" d=\"";
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto [x, y] = flat.at(places[i].place);
        out += (i == 0 ? "M" : "L") + num(x) + " " + num(y);
    }
    return out + (closed ? "Z\"/>" : "\"/>");
}

std::string base64(std::span<const std::uint8_t> bytes) {
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t v = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            v = v << 8U | (i + k < bytes.size() ? bytes[i + k] : 0U);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            out += i + k <= bytes.size() ? kDigits[v >> (18U - 6U * k) & 63U] : '=';
        }
    }
    return out;
}

/// Place in 16 bits each over the box, then the colour: 0 lack .. 126 as asked .. 252 excess; kGrey, kLine.
void add_point(std::vector<std::uint8_t>& out, const Vec3& low, double step, const Vec3& place, std::uint8_t colour) {
    for (std::size_t i = 0; i < 3; ++i) {
        const auto v = static_cast<std::uint32_t>(std::clamp((place[i] - low[i]) / step, 0.0, 65535.0));
        out.push_back(static_cast<std::uint8_t>(v & 255U));
        out.push_back(static_cast<std::uint8_t>(v >> 8U));
    }
    out.push_back(colour);
}

/// Spread over the faces of the CAD model that ask for nothing.
void add_grey(std::vector<std::uint8_t>& out, const Inspection& inspection, const TriangleMesh& mesh,
              const Vec3& origin, double step) {
    double area = 0.0;
    for (const CadFace& face : inspection.map.faces) {
        area += face.area;
    }
    double due = 0.0;
    double u = 0.5;
    double v = 0.5;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const auto& t = mesh.triangles[i];
        const Vec3 ab = mesh.vertices[t[1]] - mesh.vertices[t[0]];
        const Vec3 ac = mesh.vertices[t[2]] - mesh.vertices[t[0]];
        if (inspection.plan.group_of_face[inspection.map.face_of[i]] != kNoGroup) {
            continue;
        }
        due += 0.5 * norm(cross(ab, ac)) / area * kGreyPoints;
        const auto count = static_cast<int>(due);
        due -= count;
        for (int k = 0; k < count; ++k) {
            u = std::fmod(u + 0.7548776662, 1.0);  // even and without chance (the plastic number's sequence)
            v = std::fmod(v + 0.5698402910, 1.0);
            const bool beyond = u + v > 1.0;
            const double a = beyond ? 1.0 - u : u;
            const double b = beyond ? 1.0 - v : v;
            add_point(out, origin, step, mesh.vertices[t[0]] + a * ab + b * ac, kGrey);
        }
    }
}

constexpr const char* kScript = R"JS(
(function(){
var raw=atob(document.getElementById('cloud').textContent.trim()),n=raw.length/7|0,P=new Float32Array(3*n),K=new Uint8Array(n),i,k;
for(i=0;i<n;i++){for(k=0;k<3;k++)P[3*i+k]=(raw.charCodeAt(7*i+2*k)+256*raw.charCodeAt(7*i+2*k+1))/65535-0.5;K[i]=raw.charCodeAt(7*i+6);}
var c=document.getElementById('map'),g=c.getContext('2d'),a=0.7,b=-0.5,z=0.85,down=null;
function colour(k){if(k===255)return[20,120,20];if(k===254)return[200,200,200];var t=(k-126)/126,s=Math.abs(t),w=1-s;return t>=0?[235-15*s,225*w+40*s,205*w+30*s]:[205*w+30*s,220*w+70*s,240-10*s];}
function draw(){var W=c.width,H=c.height,im=g.createImageData(W,H),d=im.data,D=new Float32Array(W*H).fill(-9),ca=Math.cos(a),sa=Math.sin(a),cb=Math.cos(b),sb=Math.sin(b),S=z*Math.min(W,H),i,x,y,q;
for(i=0;i<d.length;i+=4){d[i]=d[i+1]=d[i+2]=250;d[i+3]=255;}
for(i=0;i<n;i++){x=P[3*i]*ca-P[3*i+1]*sa;y=P[3*i]*sa+P[3*i+1]*ca;q=y*cb-P[3*i+2]*sb;y=y*sb+P[3*i+2]*cb;var r=K[i]===255?1:2,X=W/2+S*x|0,Y=H/2-S*y|0,C=colour(K[i]),u,v;if(K[i]===255)q-=0.01;
for(u=-r;u<=r;u++)for(v=-r;v<=r;v++){var xx=X+u,yy=Y+v;if(xx<0||yy<0||xx>=W||yy>=H)continue;var o=yy*W+xx;if(-q>D[o]){D[o]=-q;var s=0.75+0.35*Math.max(-0.5,Math.min(0.7,-q+0.2));d[4*o]=C[0]*s;d[4*o+1]=C[1]*s;d[4*o+2]=C[2]*s;}}}
g.putImageData(im,0,0);c.dataset.drawn=String(n);}
c.onpointerdown=function(e){down=[e.clientX,e.clientY];c.setPointerCapture(e.pointerId);};
c.onpointermove=function(e){if(!down)return;a+=(e.clientX-down[0])*0.01;b+=(e.clientY-down[1])*0.01;down=[e.clientX,e.clientY];draw();};
c.onpointerup=function(){down=null;};
c.onwheel=function(e){e.preventDefault();z*=Math.exp(-e.deltaY*0.001);draw();};
draw();})();
)JS";

}  // namespace

std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            case '&': out += "&amp;"; break;
            case '"': out += "&quot;"; break;
            default: out += c;
        }
    }
    return out;
}

std::string histogram_svg(const FaceAllowance& before, const FaceAllowance* after) {
    const FaceAllowance& shown = after != nullptr ? *after : before;
    std::size_t most = 1;
    for (const std::size_t n : shown.histogram) {
        most = std::max(most, n);
    }
    std::string body;
    constexpr double kBar = 11.0;
    for (std::size_t i = 0; i < kHistogram; ++i) {
        const double middle = shown.histogram_low + (static_cast<double>(i) + 0.5) * shown.histogram_width;
        const double height = 70.0 * static_cast<double>(shown.histogram[i]) / static_cast<double>(most);
        body += rect(10.0 + kBar * static_cast<double>(i), 80.0 - height, kBar - 1.0, height,
                     middle < shown.least_asked ? "lack" : "more");
    }
    const double width = kBar * static_cast<double>(kHistogram);
    const double high = shown.histogram_low + static_cast<double>(kHistogram) * shown.histogram_width;
    body += stroke(10, 80, 10 + width, 80, "axis") + label(10, 94, num(kMm * shown.histogram_low), "start") +
            label(10 + width, 94, num(kMm * high) + " mm", "end");
    if (shown.histogram_width > 0.0 && shown.least_asked > shown.histogram_low && shown.least_asked < high) {
        const double x = 10.0 + width * (shown.least_asked - shown.histogram_low) / (high - shown.histogram_low);
        body += stroke(x, 5, x, 80, "asked") + label(x, 94, num(kMm * shown.least_asked));
    }
    return "<figure><figcaption>" + escaped(shown.id) + "</figcaption>" + svg(width + 20.0, 100, body) + "</figure>";
}

std::string sides_svg(const AllowanceReport& before, const AllowanceReport* after) {
    double most = 1e-6;
    for (const AllowanceReport* report : {&before, after}) {
        for (std::size_t i = 0; report != nullptr && i < 6; ++i) {
            most = std::max(most, report->sides[i / 2][i % 2].mean);
        }
    }
    std::string body;
    double x = 40.0;
    for (std::size_t i = 0; i < 6; ++i) {
        const auto bar = [&](const AllowanceReport& report, double at, const char* style) {
            const Side& side = report.sides[i / 2][i % 2];
            const double height = 110.0 * std::max(side.mean, 0.0) / most;
            return side.count == 0 ? std::string()
                                   : rect(at, 130.0 - height, 26, height, style) +
                                         label(at + 13, 126.0 - height, fixed(kMm * side.mean, 3));
        };
        if (before.sides[i / 2][i % 2].count > 0) {
            body += bar(before, x, "before");
            body += after != nullptr ? bar(*after, x + 30.0, "after") : std::string();
            body += label(x + 28, 146, kSides[i]);
            x += i % 2 == 0 ? 76.0 : 100.0;
        }
    }
    return svg(x, 150, stroke(30, 130, x - 20.0, 130, "axis") + body);
}

std::string section_svg(const DatumLine& line, const TriangleMesh& mesh) {
    const std::vector<SectionPiece> pieces = section(mesh, line.plane);
    Flat flat(line.plane);
    for (const SectionPiece& piece : pieces) {
        flat.take(piece.from);
    }
    for (const LineRun& run : line.cut.runs) {
        for (const LinePlace& at : run.places) {
            flat.take(at.place);
        }
    }
    std::string body = "<path class=\"cad\" d=\"";
    for (const SectionPiece& piece : pieces) {
        const auto [x1, y1] = flat.at(piece.from);
        const auto [x2, y2] = flat.at(piece.to);
        body += "M" + num(x1) + " " + num(y1) + "L" + num(x2) + " " + num(y2);
    }
    body += "\"/>";
    for (const LineRun& run : line.cut.runs) {
        body += path_of(flat, run.places, run.closed);
    }
    for (const LineGap& gap : line.cut.gaps) {
        const auto [x1, y1] = flat.at(gap.from);
        const auto [x2, y2] = flat.at(gap.to);
        body += stroke(x1, y1, x2, y2, "gap");
    }
    const double ten = 0.01 * flat.scale();
    body += stroke(20, flat.height() - 6, 20 + ten, flat.height() - 6, "axis") +
            label(26 + ten, flat.height() - 2, "10 mm", "start");
    return "<figure><figcaption>datum " + escaped(line.id) + ": " + fixed(kMm * line.cut.length, 1) + " mm, " +
           std::to_string(line.cut.gaps.size()) + " gaps</figcaption>" + svg(Flat::kWide + 40.0, flat.height(), body) +
           "</figure>";
}

std::string map_html(const Inspection& inspection, const DistanceField& field, double margin_scale) {
    const FaceGauge gauge(field, inspection.map);
    const Rigid<frame::W, frame::W> motion =
        inspection.borrowing ? inspection.borrowing->motion : Rigid<frame::W, frame::W>{};
    const Vec3 room = 0.1 * (field.high() - field.low());
    const Vec3 low = field.low() - room;
    const Vec3 size = field.high() + room - low;
    const double longest = std::max({size.x, size.y, size.z});
    const Vec3 origin = low - 0.5 * (Vec3{longest, longest, longest} - size);
    std::vector<std::uint8_t> bytes;
    const auto& points = inspection.over.points;
    const std::size_t stride = std::max<std::size_t>(1, points.size() / kMapPoints);
    for (std::size_t i = 0; i < points.size(); i += stride) {
        const Vec3 place = (motion * Point<frame::W>{points[i].place}).v;
        const BorrowGroup& group = inspection.plan.groups[points[i].group];
        const double margin = gauge.at(place, group.face).value - group.least;
        const double share = std::clamp(margin / margin_scale, -1.0, 1.0);
        add_point(bytes, origin, longest / 65535.0, place,
                  static_cast<std::uint8_t>(std::lround(126.0 + 126.0 * share)));
    }
    add_grey(bytes, inspection, field.mesh(), origin, longest / 65535.0);
    for (const DatumLine& line : inspection.lines) {
        for (const LineRun& run : line.cut.runs) {
            for (std::size_t i = 1; i < run.places.size(); ++i) {
                const Vec3 way = run.places[i].place - run.places[i - 1].place;
                const int steps = std::max(1, static_cast<int>(norm(way) / (0.002 * longest)));
                for (int k = 0; k < steps; ++k) {
                    const double share = static_cast<double>(k) / steps;
                    add_point(bytes, origin, longest / 65535.0, run.places[i - 1].place + share * way, kLine);
                }
            }
        }
    }
    return "<canvas id=\"map\" width=\"760\" height=\"560\"></canvas><p class=\"scale\"><span>-" +
           fixed(kMm * margin_scale, 2) +
           " mm lacking</span><span class=\"bar\"></span><span>as asked in the middle, +" +
           fixed(kMm * margin_scale, 2) + " mm to spare</span></p><script type=\"text/plain\" id=\"cloud\">" +
           base64(bytes) + "</script><script>" + kScript + "</script>";
}

}  // namespace sc::host
