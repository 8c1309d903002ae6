// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/camera/plate_camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>
#include <stdexcept>

namespace sc::sim {
namespace {

constexpr std::int64_t kPauseNs = 1'000'000;
constexpr std::size_t kFewestMarks = 3;
/// Without noise a place is still written with this uncertainty: rounding to 1 nm and the bend of a stroke.
constexpr double kLeastSigma = 0.1e-6;

struct Line {
    Vec3 middle;
    double x = 0.0;  ///< direction
    double z = 0.0;
};

/// Line of least squares through marks, in x and z.
Line line_through(std::span<const Vec3> marks) {
    if (marks.size() < kFewestMarks) {
        throw std::runtime_error("a stroke of " + std::to_string(marks.size()) + " marks is none");
    }
    Line line;
    for (const Vec3& mark : marks) {
        line.middle = line.middle + mark;
    }
    line.middle = (1.0 / static_cast<double>(marks.size())) * line.middle;
    double xx = 0.0;
    double xz = 0.0;
    double zz = 0.0;
    for (const Vec3& mark : marks) {
        const double x = mark.x - line.middle.x;
        const double z = mark.z - line.middle.z;
        xx += x * x;
        xz += x * z;
        zz += z * z;
    }
    const double angle = 0.5 * std::atan2(2.0 * xz, xx - zz);
    line.x = std::cos(angle);
    line.z = std::sin(angle);
    return line;
}

SeenCross meet(const Line& a, const Line& b) {
    const double determinant = a.x * b.z - a.z * b.x;
    if (!(std::abs(determinant) > 0.5)) {
        throw std::runtime_error("two strokes in a row are no cross: they are not square to each other");
    }
    const double dx = b.middle.x - a.middle.x;
    const double dz = b.middle.z - a.middle.z;
    const double along = (dx * b.z - dz * b.x) / determinant;
    return {{a.middle.x + along * a.x, 0.5 * (a.middle.y + b.middle.y), a.middle.z + along * a.z}};
}

Vec3 metres(const std::array<std::int64_t, 3>& pm) {
    return {static_cast<double>(pm[0]) * 1e-12, static_cast<double>(pm[1]) * 1e-12, static_cast<double>(pm[2]) * 1e-12};
}

}  // namespace

std::vector<SeenCross> find_plate_crosses(std::span<const trace::PulseRecord> pulses) {
    std::vector<Line> lines;
    std::vector<Vec3> marks;
    std::int64_t last_ns = 0;
    for (const trace::PulseRecord& pulse : pulses) {
        if (!marks.empty() && pulse.t_ns - last_ns > kPauseNs) {
            lines.push_back(line_through(marks));
            marks.clear();
        }
        last_ns = pulse.t_ns;
        if (pulse.hit == 1) {
            marks.push_back(metres(pulse.place_pm));
        }
    }
    if (!marks.empty()) {
        lines.push_back(line_through(marks));
    }
    if (lines.size() % 2 != 0) {
        throw std::runtime_error(std::to_string(lines.size()) + " strokes are no whole number of crosses");
    }
    std::vector<SeenCross> crosses;
    for (std::size_t i = 0; i < lines.size(); i += 2) {
        crosses.push_back(meet(lines[i], lines[i + 1]));
    }
    return crosses;
}

std::vector<trace::PulseRecord> read_pulses(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::array<char, 12> head{};
    if (!in.read(head.data(), head.size()) ||
        !std::equal(trace::kPulseMagic.begin(), trace::kPulseMagic.end(), head.begin())) {
        throw std::runtime_error(file.string() + " is no pulse trace");
    }
    std::uint32_t header = 0;
    for (unsigned i = 0; i < 4; ++i) {
        header |= static_cast<std::uint32_t>(static_cast<unsigned char>(head[8 + i])) << (8 * i);
    }
    in.ignore(header);
    std::vector<trace::PulseRecord> pulses;
    std::array<char, trace::kPulseRecordSize> bytes{};
    while (in.read(bytes.data(), bytes.size())) {
        std::array<std::uint8_t, trace::kPulseRecordSize> record{};
        std::copy(bytes.begin(), bytes.end(), record.begin());
        pulses.push_back(trace::unpack_pulse(record));
    }
    if (in.gcount() != 0) {
        throw std::runtime_error(file.string() + " ends within a record");
    }
    return pulses;
}

std::string measured_csv(std::span<const SeenCross> crosses, double sigma, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::string text = "no,x,y,z,sigma\n";
    int no = 0;
    for (const SeenCross& cross : crosses) {
        const double x = cross.place.x + sigma * normal(random);
        const double z = cross.place.z + sigma * normal(random);
        std::array<char, 120> line{};
        std::snprintf(line.data(), line.size(), "%d,%.6f,%.6f,%.6f,%.6f\n", ++no, x * 1e3, cross.place.y * 1e3, z * 1e3,
                      std::max(sigma, kLeastSigma) * 1e3);
        text += line.data();
    }
    return text;
}

std::vector<SeenMark> find_plate_marks(std::span<const trace::PulseRecord> pulses) {
    std::vector<SeenMark> marks;
    int line = 0;
    int mark = 0;
    std::int64_t last_ns = 0;
    for (const trace::PulseRecord& pulse : pulses) {
        if (line == 0 || pulse.t_ns - last_ns > kPauseNs) {
            ++line;
            mark = 0;
        }
        last_ns = pulse.t_ns;
        if (pulse.hit == 1) {
            marks.push_back({line, mark, metres(pulse.place_pm)});
        }
        ++mark;
    }
    return marks;
}

std::string marks_csv(std::span<const SeenMark> marks, double sigma, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::string text = "line,mark,x,y,z,sigma\n";
    for (const SeenMark& mark : marks) {
        const double x = mark.place.x + sigma * normal(random);
        const double z = mark.place.z + sigma * normal(random);
        std::array<char, 140> row{};
        std::snprintf(row.data(), row.size(), "%d,%d,%.6f,%.6f,%.6f,%.6f\n", mark.line, mark.mark, x * 1e3,
                      mark.place.y * 1e3, z * 1e3, std::max(sigma, kLeastSigma) * 1e3);
        text += row.data();
    }
    return text;
}

}  // namespace sc::sim
