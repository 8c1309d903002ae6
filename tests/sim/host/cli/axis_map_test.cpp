// SPDX-License-Identifier: Apache-2.0
// A cell whose axes are bent, loose and out of true, measured by an instrument, calibrated from the files that the
// instrument wrote, and scribed with and without the map: all by the programs as a person would run them.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "boards/sim/world/machine_errors.hpp"
#include "boards/sim/world/world_spec.hpp"
#include "program.hpp"

namespace sc::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kNoise = 0.5e-6;  ///< of the instrument, metres, each coordinate

const std::string kBentWorld = std::string("version = 1\nbase = \"") + SC_SOURCE_DIR +
                               R"(/boards/sim/world/default/world.toml"
[axes.periodic]
x_of_x = { amplitude_um = 25.0, period_mm = 310.0, phase_deg = 20.0 }
x_of_y = { amplitude_um = 15.0, period_mm = 260.0, phase_deg = 75.0 }
x_of_z = { amplitude_um = 15.0, period_mm = 240.0, phase_deg = 140.0 }
y_of_x = { amplitude_um = 20.0, period_mm = 350.0, phase_deg = 210.0 }
y_of_y = { amplitude_um = 20.0, period_mm = 290.0, phase_deg = 95.0 }
y_of_z = { amplitude_um = 15.0, period_mm = 300.0, phase_deg = 310.0 }
z_of_x = { amplitude_um = 25.0, period_mm = 250.0, phase_deg = 35.0 }
z_of_y = { amplitude_um = 15.0, period_mm = 280.0, phase_deg = 180.0 }
z_of_z = { amplitude_um = 25.0, period_mm = 220.0, phase_deg = 265.0 }
[turntable]
runout_um = 10.0
wobble_urad = 25.0
pitch_error_mdeg = 8.0
radial2_um = 8.0
axial_um = 15.0
tilt2_urad = 15.0
pitch_error2_mdeg = 4.0
[drives]
backlash_x_um = 25.0
backlash_y_um = 20.0
backlash_z_um = 30.0
backlash_c_mdeg = 6.0
)";

/// Writes what a measuring instrument sees of the cell. It knows the truth; its files carry noise, and nothing else
/// leaves it.
class Instrument {
public:
    explicit Instrument(const fs::path& world) : spec_(sim::read_world_spec(world)) {}

    void measure_axes(const fs::path& file, const std::vector<std::vector<double>>& levels_mm) {
        std::ofstream out(file);
        out << "x,y,z,dir_x,dir_y,dir_z,true_x,true_y,true_z\n";
        constexpr std::array<double, 3> kFrom{-450.0, -400.0, -500.0};
        for (std::size_t along = 0; along < 3; ++along) {
            const std::size_t b = (along + 1) % 3;
            const std::size_t c = (along + 2) % 3;
            for (const double level_b : levels_mm[b]) {
                for (const double level_c : levels_mm[c]) {
                    for (double mm = kFrom[along]; mm <= 5.0; mm += 9.1) {
                        std::array<double, 3> reading{};
                        reading[along] = mm;
                        reading[b] = level_b;
                        reading[c] = level_c;
                        axes_row(out, reading);
                    }
                }
            }
        }
    }

    void measure_table(const fs::path& file, double step_deg) {
        std::ofstream out(file);
        out << "c,dir_c,target,true_x,true_y,true_z\n";
        const std::vector<Vec3> targets{
            {-0.10, -0.45, -0.47}, {-0.30, -0.33, -0.30}, {-0.38, -0.52, -0.42}, {-0.22, -0.62, -0.25}};
        for (double c = -180.0; c < 180.0; c += step_deg) {
            const int side = way();
            const double load = c - 0.5 * side * spec_.drives.backlash[3];
            for (std::size_t k = 0; k < targets.size(); ++k) {
                const auto place = sim::true_h_from_t(spec_.turntable, load) * Point<frame::T>{targets[k]};
                out << fmt::format("{},{},{},{}\n", c, side, k + 1, seen(place.v));
            }
        }
    }

private:
    int way() { return random_() % 2 == 0 ? 1 : -1; }
    std::string seen(const Vec3& place) {
        const auto mm = [this](double v) { return (v + kNoise * normal_(random_)) * 1e3; };
        return fmt::format("{:.6f},{:.6f},{:.6f}", mm(place.x), mm(place.y), mm(place.z));
    }
    void axes_row(std::ofstream& out, const std::array<double, 3>& mm) {
        std::array<int, 3> side{};
        std::array<double, 3> load{};
        for (std::size_t i = 0; i < 3; ++i) {
            side[i] = way();
            load[i] = mm[i] * 1e-3 - 0.5 * side[i] * spec_.drives.backlash[i];
        }
        const Vec3 place = sim::true_focus(spec_.axes, {load[0], load[1], load[2]});
        out << fmt::format("{:.4f},{:.4f},{:.4f},{},{},{},{}\n", mm[0], mm[1], mm[2], side[0], side[1], side[2],
                           seen(place));
    }

    sim::WorldSpec spec_;
    std::mt19937_64 random_{7};
    std::normal_distribution<double> normal_;
};

const std::vector<std::vector<double>> kLevels{
    {-440.0, -220.0, -10.0}, {-390.0, -200.0, -10.0}, {-490.0, -250.0, -10.0}};
const std::string kBase = std::string(SC_SOURCE_DIR) + "/examples/ras3dm/calibration.toml";

/// Files of the bent cell, made once.
struct Bent {
    fs::path folder = fs::temp_directory_path() / fmt::format("scribecell_bent_{}", ::getpid());
    fs::path world = folder / "world.toml";
    fs::path axes = folder / "axes.csv";
    fs::path table = folder / "table.csv";
    Bent() {
        fs::create_directories(folder);
        write_file(world, kBentWorld);
        Instrument instrument(world);
        instrument.measure_axes(axes, kLevels);
        instrument.measure_table(table, 5.0);
    }
    ~Bent() { fs::remove_all(folder); }
    Bent(const Bent&) = delete;
    Bent& operator=(const Bent&) = delete;
};

Json calibrate(const std::vector<std::string>& arguments, int code = 0) {
    std::vector<std::string> words{"calibrate", "axes", "--json", "--calibration", kBase};
    words.insert(words.end(), arguments.begin(), arguments.end());
    Program program("scribecell", words);
    EXPECT_EQ(program.wait(), code) << program.err();
    return Json::parse(program.out());
}

Json scribe(const std::vector<std::string>& arguments) {
    std::vector<std::string> words{"scribe", "--json"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    Program program("scribecell", words);
    EXPECT_EQ(program.wait(), 0) << program.err();
    return Json::parse(program.out());
}

TEST(AxisMapOfACell, TakesTensOfMicrometresOutOfABentCell) {
    const Bent bent;
    const std::string map = (bent.folder / "map.toml").string();
    const Json fit =
        calibrate({"--measurements", bent.axes.string(), "--table-measurements", bent.table.string(), "--out", map});
    EXPECT_LT(fit["axes"]["residual_rms_um"].get<double>(), 1.5);
    EXPECT_LT(fit["table"]["residual_rms_um"].get<double>(), 1.5);
    EXPECT_NEAR(fit["backlash_um"][0].get<double>(), 25.0, 0.5);
    EXPECT_NEAR(fit["backlash_um"][2].get<double>(), 30.0, 0.5);
    EXPECT_NEAR(fit["backlash_c_mdeg"].get<double>(), 6.0, 0.3);

    const Json without = scribe({"--world", bent.world.string(), "--calibration", kBase});
    const Json with = scribe({"--world", bent.world.string(), "--calibration", map});
    EXPECT_GT(without["max_command_error_um"].get<double>(), 60.0);
    // C has not moved since homing when face 0 is burnt: on which side of its 6 mdeg it stands is not known then.
    EXPECT_LT(with["max_command_error_um"].get<double>(), 10.0);
    EXPECT_EQ(with["limit_violations"], 0);
    EXPECT_EQ(with["complete"], true);
    RecordProperty("without_um", fmt::format("{:.2f}", without["max_command_error_um"].get<double>()));
    RecordProperty("with_um", fmt::format("{:.2f}", with["max_command_error_um"].get<double>()));
    for (std::size_t face = 0; face < with["datum_lines"].size(); ++face) {
        const double straight = with["datum_lines"][face]["straightness_um"];
        EXPECT_LT(straight, 6.0) << "face " << face;
        std::printf("datum line %zu: straight to %.1f um without, %.1f um with the map\n", face,
                    without["datum_lines"][face]["straightness_um"].get<double>(), straight);
    }
    std::printf("largest error of a cross: %.1f um without, %.2f um with the map\n",
                without["max_command_error_um"].get<double>(), with["max_command_error_um"].get<double>());
}

TEST(AxisMapOfACell, RefusesWhatTheDataCannotSupport) {
    const Bent bent;
    const std::string out = (bent.folder / "out.toml").string();
    const auto refused = [&](const std::string& option, const fs::path& file, const std::string& says) {
        const Json json = calibrate({option, file.string(), "--out", out}, 2);
        EXPECT_NE(json["error"]["text"].get<std::string>().find(says), std::string::npos) << json;
        EXPECT_FALSE(fs::exists(out));
    };
    const std::string good = read_file(bent.axes);
    const auto variant = [&](const char* name, const std::string& text) {
        write_file(bent.folder / name, text);
        return bent.folder / name;
    };
    // One line along each axis alone cannot tell a bend from a lean elsewhere; a hole in the table's angles.
    Instrument instrument(bent.world);
    instrument.measure_table(bent.folder / "coarse.csv", 40.0);
    refused("--table-measurements", bent.folder / "coarse.csv", "too few");
    std::string half;
    std::istringstream rows(good);
    for (std::string row; std::getline(rows, row);) {
        const bool header = row.starts_with("x");
        half += header || std::stod(row) < -200.0 ? row + "\n" : "";
    }
    refused("--measurements", variant("half.csv", half), "say too little about");
    std::string table;
    std::istringstream table_rows(read_file(bent.table));
    for (std::string row; std::getline(table_rows, row);) {
        const bool header = row.starts_with("c");
        table += header || std::abs(std::stod(row) - 60.0) > 35.0 ? row + "\n" : "";
    }
    refused("--table-measurements", variant("hole.csv", table), "say too little about C");
    std::string side = good;
    for (std::size_t at = side.find(",-1,"); at != std::string::npos; at = side.find(",-1,")) {
        side.replace(at, 4, ",1,");
    }
    refused("--measurements", variant("side.csv", side), "from the same side");
    const std::size_t end = good.rfind('\n', good.size() - 2);
    refused("--measurements",
            variant("outlier.csv", good.substr(0, end) + "\n-100.0,-100.0,-100.0,1,1,1,-100.3,-100,-100\n"), "far off");
    refused("--measurements", variant("few.csv", good.substr(0, good.find('\n', 2000) + 1)), "too few");
}

}  // namespace
}  // namespace sc::test
