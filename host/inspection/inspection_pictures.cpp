// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/inspection_pictures.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <string>

#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"
#include "host/inspection/allowance_map.hpp"
#include "host/inspection/inspection_drawings.hpp"

namespace sc::host {

namespace {

constexpr double kScale = 1e-3;  ///< metres at full colour
constexpr int kWide = 380;       ///< cells of the map
constexpr int kHigh = 280;
constexpr double kCell = 2.0;  ///< of the picture's units

constexpr const char* kStyle =
    "<style>text{font:11px sans-serif;fill:#444}.axis{stroke:#444}.asked{stroke:#000;stroke-dasharray:3 2}"
    ".lack{fill:#3c66d6}.more{fill:#d9683c}.before{fill:#b9b9b9}.after{fill:#d9683c}.cad{stroke:#999;fill:none}"
    ".run{stroke:#157015;stroke-width:1.6;fill:none}.gap{stroke:#b3261e;stroke-dasharray:4 3}</style>";

/// The drawing within an element of the page, as a document of its own.
std::string document(const std::string& element) {
    const std::size_t begin = element.find("<svg");
    const std::size_t body = element.find('>', begin) + 1;
    const std::size_t end = element.rfind("</svg>");
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\"" +
           element.substr(begin + 4, body - begin - 4) + kStyle + element.substr(body, end - body) + "</svg>\n";
}

/// What stands foremost in each cell of the picture.
class Raster {
public:
    explicit Raster(const DistanceField& field) : middle_(0.5 * (field.low() + field.high())) {
        const double reach = norm(field.high() - field.low());
        cells_a_metre_ = 0.95 * kHigh / reach;
    }
    /// As the page's map stands at first: turned by 0.7 rad about z, tilted by -0.5 rad.
    void take(const Vec3& place, const std::array<std::uint8_t, 3>& colour, double nearer, int half) {
        const Vec3 p = place - middle_;
        const double across = p.x * std::cos(0.7) - p.y * std::sin(0.7);
        const double away = p.x * std::sin(0.7) + p.y * std::cos(0.7);
        const double depth = away * std::cos(-0.5) - p.z * std::sin(-0.5) - nearer;
        const double up = away * std::sin(-0.5) + p.z * std::cos(-0.5);
        const int column = kWide / 2 + static_cast<int>(std::floor(cells_a_metre_ * across));
        const int row = kHigh / 2 - static_cast<int>(std::floor(cells_a_metre_ * up));
        for (int r = std::max(row - half, 0); r <= std::min(row + half, kHigh - 1); ++r) {
            for (int c = std::max(column - half, 0); c <= std::min(column + half, kWide - 1); ++c) {
                Cell& cell = cells_[static_cast<std::size_t>(r) * kWide + static_cast<std::size_t>(c)];
                if (!cell.filled || depth < cell.depth) {
                    cell = {depth, colour, true};
                }
            }
        }
    }
    [[nodiscard]] std::string drawn() const {
        std::map<std::array<std::uint8_t, 3>, std::string> paths;
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            if (cells_[i].filled) {
                const std::size_t row = i / kWide;
                const std::size_t column = i % kWide;
                paths[cells_[i].colour] += "M" + fixed(kCell * static_cast<double>(column), 0) + " " +
                                           fixed(kCell * static_cast<double>(row), 0) + "h2v2h-2z";
            }
        }
        std::string out;
        for (const auto& [colour, path] : paths) {
            out += "<path fill=\"rgb(" + std::to_string(colour[0]) + "," + std::to_string(colour[1]) + "," +
                   std::to_string(colour[2]) + ")\" d=\"" + path + "\"/>";
        }
        return out;
    }

private:
    struct Cell {
        double depth = 0.0;
        std::array<std::uint8_t, 3> colour{};
        bool filled = false;
    };
    Vec3 middle_;
    double cells_a_metre_ = 1.0;
    std::vector<Cell> cells_ = std::vector<Cell>(static_cast<std::size_t>(kWide * kHigh));
};

std::string map_svg(const Inspection& inspection, const DistanceField& field) {
    Raster raster(field);
    // 33 colours are enough for an eye, and keep the file small.
    for (const MapPoint& point : map_points(inspection, field)) {
        const double step = kScale / 16.0;
        const double margin = step * std::round(std::clamp(point.margin, -kScale, kScale) / step);
        raster.take(point.place, map_colour(margin, kScale), 0.0, 1);
    }
    const TriangleMesh& mesh = field.mesh();
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (inspection.plan.group_of_face[inspection.map.face_of[i]] != kNoGroup) {
            continue;
        }
        const auto& t = mesh.triangles[i];
        const Vec3 ab = mesh.vertices[t[1]] - mesh.vertices[t[0]];
        const Vec3 ac = mesh.vertices[t[2]] - mesh.vertices[t[0]];
        const double fine = 0.3 * norm(field.high() - field.low()) / kHigh;
        const int steps = std::max(1, static_cast<int>(std::max(norm(ab), norm(ac)) / fine));
        for (int u = 0; u <= steps; ++u) {
            for (int v = 0; u + v <= steps; ++v) {
                raster.take(
                    mesh.vertices[t[0]] + (static_cast<double>(u) / steps) * ab + (static_cast<double>(v) / steps) * ac,
                    {200, 200, 200}, 0.0, 0);
            }
        }
    }
    for (const DatumLine& line : inspection.lines) {
        for (const LineRun& run : line.cut.runs) {
            for (const LinePlace& at : run.places) {
                raster.take(at.place, {20, 120, 20}, 1e-3, 0);
            }
        }
    }
    std::string legend;
    for (int i = 0; i <= 32; ++i) {
        const auto colour = map_colour(kScale * (i - 16) / 16.0, kScale);
        legend += "<rect x=\"" + std::to_string(200 + 10 * i) + "\" y=\"570\" width=\"10\" height=\"10\" fill=\"rgb(" +
                  std::to_string(colour[0]) + "," + std::to_string(colour[1]) + "," + std::to_string(colour[2]) +
                  ")\"/>";
    }
    legend +=
        "<text x=\"190\" y=\"579\" text-anchor=\"end\">-1.00 mm lacking</text><text x=\"365\" y=\"595\" "
        "text-anchor=\"middle\">as asked</text><text x=\"540\" y=\"579\">+1.00 mm to spare</text>";
    return "<svg viewBox=\"0 0 760 600\" width=\"760\">" + raster.drawn() + legend + "</svg>";
}

std::string file_name(const std::string& id) {
    std::string out;
    for (const char c : id) {
        out += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' ? c : '_';
    }
    return out;
}

}  // namespace

std::vector<std::filesystem::path> write_pictures(const std::filesystem::path& folder, const Inspection& inspection,
                                                  const DistanceField& field) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    if (failed) {
        throw InputError({.file = folder.string(),
                          .problem = "the folder for the pictures cannot be made",
                          .value = failed.message(),
                          .action = "name another with --pictures"});
    }
    std::vector<std::filesystem::path> out;
    const auto write = [&](const std::string& name, const std::string& element) {
        out.push_back(folder / (name + ".svg"));
        write_text_file(out.back(), document(element));
    };
    const AllowanceReport* after = inspection.after ? &*inspection.after : nullptr;
    write("map", map_svg(inspection, field));
    write("sides", sides_svg(inspection.before, after));
    for (std::size_t k = 0; k < inspection.before.faces.size(); ++k) {
        const FaceAllowance& face = inspection.before.faces[k];
        if (face.count > 0) {
            write("histogram_" + file_name(face.id),
                  histogram_svg(face, after != nullptr ? &after->faces[k] : nullptr));
        }
    }
    for (const DatumLine& line : inspection.lines) {
        write("datum_" + file_name(line.id), section_svg(line, field.mesh()));
    }
    return out;
}

}  // namespace sc::host
