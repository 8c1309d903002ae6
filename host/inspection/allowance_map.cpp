// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/allowance_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>
#include <string_view>

#include "host/formats/file.hpp"
#include "host/formats/text.hpp"
#include "host/inspection/face_gauge.hpp"

namespace sc::host {

namespace {

constexpr double kMm = 1e3;
constexpr std::size_t kMapPoints = 24000;
constexpr double kGreyPoints = 16000.0;
constexpr std::uint32_t kGrey = 254;  ///< surfaces that ask for nothing
constexpr std::uint32_t kLine = 255;

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

/// Twelve bytes: place in 16 bits each over the box, margin in micrometres, direction in 127ths, kind.
void add_point(std::vector<std::uint8_t>& out, const Vec3& low, double step, const MapPoint& point) {
    const auto two = [&](std::uint32_t v) {
        out.push_back(static_cast<std::uint8_t>(v & 255U));
        out.push_back(static_cast<std::uint8_t>(v >> 8U & 255U));
    };
    for (std::size_t i = 0; i < 3; ++i) {
        two(static_cast<std::uint32_t>(std::clamp((point.place[i] - low[i]) / step, 0.0, 65535.0)));
    }
    two(static_cast<std::uint32_t>(std::lround(std::clamp(1e6 * point.margin, -32767.0, 32767.0))));
    for (std::size_t i = 0; i < 3; ++i) {
        out.push_back(static_cast<std::uint8_t>(std::lround(127.0 * point.direction[i]) & 255));
    }
    out.push_back(static_cast<std::uint8_t>(std::min(point.group, kLine)));
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
            add_point(out, origin, step, {mesh.vertices[t[0]] + a * ab + b * ac, {}, 0.0, kGrey});
        }
    }
}

/// The colours are those of map_colour. A shift is a motion of the blank in w: margins grow by direction . motion.
constexpr const char* kScript = R"JS(
(function(){
var raw=atob(document.getElementById('cloud').textContent.trim()),B=new Uint8Array(raw.length),i,k;for(i=0;i<raw.length;i++)B[i]=raw.charCodeAt(i);
var V=new DataView(B.buffer),n=raw.length/12|0,P=new Float32Array(3*n),N=new Float32Array(3*n),M0=new Float32Array(n),M=new Float32Array(n),K=new Uint8Array(n);
for(i=0;i<n;i++){for(k=0;k<3;k++){P[3*i+k]=V.getUint16(12*i+2*k,true)/65535-0.5;N[3*i+k]=V.getInt8(12*i+8+k)/127;}M[i]=M0[i]=V.getInt16(12*i+6,true)/1000;K[i]=B[12*i+11];}
var c=document.getElementById('map'),g=c.getContext('2d'),a=0.7,b=-0.5,z=0.85,down=null,size=+c.dataset.size,scale=+c.dataset.scale,base=c.dataset.along.split(',').map(Number);
function colour(i){if(K[i]===255)return[20,120,20];if(K[i]===254)return[200,200,200];var t=Math.max(-1,Math.min(1,M[i]/scale)),s=Math.abs(t),w=1-s;return t>=0?[235-15*s,225*w+40*s,205*w+30*s]:[205*w+30*s,220*w+70*s,240-10*s];}
function draw(){var W=c.width,H=c.height,im=g.createImageData(W,H),d=im.data,D=new Float32Array(W*H).fill(-9),ca=Math.cos(a),sa=Math.sin(a),cb=Math.cos(b),sb=Math.sin(b),S=z*Math.min(W,H),i,x,y,q;
for(i=0;i<d.length;i+=4){d[i]=d[i+1]=d[i+2]=250;d[i+3]=255;}
for(i=0;i<n;i++){x=P[3*i]*ca-P[3*i+1]*sa;y=P[3*i]*sa+P[3*i+1]*ca;q=y*cb-P[3*i+2]*sb;y=y*sb+P[3*i+2]*cb;var r=K[i]===255?1:2,X=W/2+S*x|0,Y=H/2-S*y|0,C=colour(i),u,v;if(K[i]===255)q-=0.01;
for(u=-r;u<=r;u++)for(v=-r;v<=r;v++){var xx=X+u,yy=Y+v;if(xx<0||yy<0||xx>=W||yy>=H)continue;var o=yy*W+xx;if(-q>D[o]){D[o]=-q;var s=0.75+0.35*Math.max(-0.5,Math.min(0.7,-q+0.2));d[4*o]=C[0]*s;d[4*o+1]=C[1]*s;d[4*o+2]=C[2]*s;}}}
g.putImageData(im,0,0);c.dataset.drawn=String(n);}
var inputs=[].slice.call(document.querySelectorAll('#shift input'));
function shift(){var s=inputs.map(function(e){return +e.value||0;}),t=[s[3],s[4],s[5]].map(function(v){return v*Math.PI/180;}),least=1e9,i;
for(i=0;i<n;i++){if(K[i]>=254)continue;var x=P[3*i]*size,y=P[3*i+1]*size,w=P[3*i+2]*size;
M[i]=M0[i]+N[3*i]*(s[0]+t[1]*w-t[2]*y)+N[3*i+1]*(s[1]+t[2]*x-t[0]*w)+N[3*i+2]*(s[2]+t[0]*y-t[1]*x);if(M[i]<least)least=M[i];}
document.getElementById('least').textContent=least.toFixed(3);
document.getElementById('exact').textContent='--what-if='+base.map(function(v,k){return +(v+s[k]).toFixed(5);}).join(',');draw();}
inputs.forEach(function(e){e.oninput=shift;});
c.onpointerdown=function(e){down=[e.clientX,e.clientY];c.setPointerCapture(e.pointerId);};
c.onpointermove=function(e){if(!down)return;a+=(e.clientX-down[0])*0.01;b+=(e.clientY-down[1])*0.01;down=[e.clientX,e.clientY];draw();};
c.onpointerup=function(){down=null;};
c.onwheel=function(e){e.preventDefault();z*=Math.exp(-e.deltaY*0.001);draw();};
shift();})();
)JS";

std::string shift_inputs() {
    std::string out = "<p id=\"shift\">Shift the blank further: ";
    for (const char* name : {"x", "y", "z"}) {
        out += std::string(name) + " <input type=\"number\" step=\"0.02\" value=\"0\"> mm ";
    }
    for (const char* name : {"rx", "ry", "rz"}) {
        out += std::string(name) + " <input type=\"number\" step=\"0.02\" value=\"0\"> deg ";
    }
    return out +
           "<br>Smallest margin of the points drawn: <b id=\"least\"></b> mm. Every point, measured exactly: "
           "<code>scribecell inspect ... <span id=\"exact\"></span></code></p>";
}

}  // namespace

std::vector<MapPoint> map_points(const Inspection& inspection, const DistanceField& field, std::size_t stride) {
    const FaceGauge gauge(field, inspection.map);
    const Rigid<frame::W, frame::W> motion =
        inspection.borrowing ? inspection.borrowing->motion : Rigid<frame::W, frame::W>{};
    std::vector<MapPoint> out;
    const auto& points = inspection.over.points;
    for (std::size_t i = 0; i < points.size(); i += stride) {
        const Vec3 place = (motion * Point<frame::W>{points[i].place}).v;
        const BorrowGroup& group = inspection.plan.groups[points[i].group];
        const Reading reading = gauge.at(place, group.face);
        out.push_back({place, reading.direction, reading.value - group.least, points[i].group});
    }
    return out;
}

std::array<std::uint8_t, 3> map_colour(double margin, double scale) noexcept {
    const double t = std::clamp(margin / scale, -1.0, 1.0);
    const double s = std::abs(t);
    const double w = 1.0 - s;
    const auto byte = [](double v) { return static_cast<std::uint8_t>(v); };
    return t >= 0.0 ? std::array{byte(235.0 - 15.0 * s), byte(225.0 * w + 40.0 * s), byte(205.0 * w + 30.0 * s)}
                    : std::array{byte(205.0 * w + 30.0 * s), byte(220.0 * w + 70.0 * s), byte(240.0 - 10.0 * s)};
}

void write_map_ply(const std::filesystem::path& file, const Inspection& inspection, const DistanceField& field,
                   double scale) {
    static_assert(std::endian::native == std::endian::little);
    const std::vector<MapPoint> points = map_points(inspection, field);
    std::string out =
        "ply\nformat binary_little_endian 1.0\ncomment allowance less what is asked, millimetres, w\n"
        "element vertex " +
        std::to_string(points.size()) +
        "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar "
        "green\nproperty uchar blue\nproperty float margin\nend_header\n";
    const auto add = [&](double metres) {
        const auto mm = static_cast<float>(kMm * metres);
        std::array<char, sizeof mm> bytes{};
        std::memcpy(bytes.data(), &mm, sizeof mm);
        out.append(bytes.data(), bytes.size());
    };
    for (const MapPoint& point : points) {
        add(point.place.x);
        add(point.place.y);
        add(point.place.z);
        for (const std::uint8_t byte : map_colour(point.margin, scale)) {
            out.push_back(static_cast<char>(byte));
        }
        add(point.margin);
    }
    write_text_file(file, out);
}

std::string map_html(const Inspection& inspection, const DistanceField& field, double scale) {
    // The middle of the box is that of the model: motions turn about it.
    const Vec3 room = 0.1 * (field.high() - field.low());
    const Vec3 low = field.low() - room;
    const Vec3 size = field.high() + room - low;
    const double longest = std::max({size.x, size.y, size.z});
    const Vec3 origin = low - 0.5 * (Vec3{longest, longest, longest} - size);
    std::vector<std::uint8_t> bytes;
    for (const MapPoint& point :
         map_points(inspection, field, std::max<std::size_t>(1, inspection.over.points.size() / kMapPoints))) {
        add_point(bytes, origin, longest / 65535.0, {point.place, point.direction, point.margin, 0});
    }
    add_grey(bytes, inspection, field.mesh(), origin, longest / 65535.0);
    for (const DatumLine& line : inspection.lines) {
        for (const LineRun& run : line.cut.runs) {
            for (std::size_t i = 1; i < run.places.size(); ++i) {
                const Vec3 way = run.places[i].place - run.places[i - 1].place;
                const int steps = std::max(1, static_cast<int>(norm(way) / (0.002 * longest)));
                for (int k = 0; k < steps; ++k) {
                    const double share = static_cast<double>(k) / steps;
                    add_point(bytes, origin, longest / 65535.0,
                              {run.places[i - 1].place + share * way, {}, 0.0, kLine});
                }
            }
        }
    }
    std::string along;
    for (std::size_t k = 0; k < 6; ++k) {
        const double v = inspection.borrowing ? inspection.borrowing->along[k] : 0.0;
        along += (k > 0 ? "," : "") + fixed(k < 3 ? kMm * v : v * 180.0 / std::numbers::pi, 6);
    }
    return "<canvas id=\"map\" width=\"760\" height=\"560\" data-size=\"" + fixed(kMm * longest, 4) +
           "\" data-scale=\"" + fixed(kMm * scale, 4) + "\" data-along=\"" + along +
           "\"></canvas><p class=\"scale\"><span>-" + fixed(kMm * scale, 2) +
           " mm lacking</span><span class=\"bar\"></span><span>as asked in the middle, +" + fixed(kMm * scale, 2) +
           " mm to spare</span></p>" + shift_inputs() + "<script type=\"text/plain\" id=\"cloud\">" + base64(bytes) +
           "</script><script>" + kScript + "</script>";
}

}  // namespace sc::host
