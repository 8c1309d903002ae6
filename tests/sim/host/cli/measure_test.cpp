// SPDX-License-Identifier: Apache-2.0
// The commands around the triple-laser head, as a person runs them: on the files of scribecell-station, and on a
// simulated cell.
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include "program.hpp"

namespace sc::test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

const fs::path kSpots = SC_TEST_DATA "/laser-spots";

struct Ended {
    int code;
    std::string out;
    std::string err;
};

Ended run(const std::vector<std::string>& arguments, const std::string& program = "scribecell") {
    Program p(program, arguments);
    const int code = p.wait();
    return {code, p.out(), p.err()};
}

/// A head, its stand and its stations, made once and calibrated by the commands under test.
class Triple : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder() = fs::path(::testing::TempDir()) / ("scribecell_triple_" + std::to_string(::getpid()));
        fs::remove_all(folder());
        ASSERT_EQ(run({"head", "--out", folder().string(), "--seed", "3"}, "scribecell-station").code, 0);
        parallelism() = run({"calibrate", "parallelism", at("stand.toml"), "--out", at("head.toml"), "--json"});
        ASSERT_EQ(parallelism().code, 0) << parallelism().err;
        reference() = run({"calibrate", "reference", "--readings", at("known_readings.csv"), "--known", at("known.csv"),
                           "--calibration", at("head.toml"), "--out", at("whole.toml"), "--json"});
        ASSERT_EQ(reference().code, 0) << reference().err;
    }
    static void TearDownTestSuite() { fs::remove_all(folder()); }

    static fs::path& folder() {
        static fs::path path;
        return path;
    }
    static Ended& parallelism() {
        static Ended ended;
        return ended;
    }
    static Ended& reference() {
        static Ended ended;
        return ended;
    }
    static std::string at(const std::string& name) { return (folder() / name).string(); }

    /// `measure` of rows of ten readings made by `row(k)`; the problem it is refused with, and that no figure is given.
    template <class Row>
    std::string problem_of(const std::string& header, Row row, const std::string& calibration = "whole.toml") {
        std::string text = header + "\n";
        for (int k = 0; k < 10; ++k) {
            text += row(k) + "\n";
        }
        const fs::path file = fresh_folder();
        fs::create_directories(file);
        write_file(file / "readings.csv", text);
        const Ended ended =
            run({"measure", (file / "readings.csv").string(), "--calibration", at(calibration), "--json"});
        fs::remove_all(file);
        EXPECT_EQ(ended.code, 1) << ended.out << ended.err;
        const json station = json::parse(ended.out).at("stations").at(0);
        EXPECT_FALSE(station.contains("angle_deg")) << station.dump();
        EXPECT_GT(station.at("text").get<std::string>().size(), 30U);
        return station.at("problem").get<std::string>();
    }
};

std::string reading(int k, double d1 = 297.6, double d2 = 293.1, double d3 = 245.7) {
    // Spread as noise of 0.1 mm would be, so that no value repeats.
    const auto spread = [k](int i) { return 0.13 * std::sin(1.7 * k + i); };
    return std::to_string(d1 + spread(1)) + "," + std::to_string(d2 + spread(2)) + "," + std::to_string(d3 + spread(3));
}

TEST_F(Triple, ParallelismFindsTheBeamsOfTheHead) {
    const json found = json::parse(parallelism().out);
    const json truth = json::parse(read_file(folder() / "head_truth.json"));
    ASSERT_EQ(found.at("beams").size(), 3U);
    ASSERT_EQ(found.at("screws").size(), 6U);
    for (std::size_t i = 0; i < 3; ++i) {
        const json& beam = found.at("beams").at(i);
        const json& true_beam = truth.at("beams").at(i);
        for (std::size_t axis = 0; axis < 2; ++axis) {
            EXPECT_NEAR(beam.at("tilt_mrad").at(axis).get<double>(), true_beam.at("tilt_mrad").at(axis).get<double>(),
                        4.0 * beam.at("tilt_sigma_mrad").at(axis).get<double>())
                << beam.dump();
            EXPECT_NEAR(beam.at("origin_mm").at(axis).get<double>(), true_beam.at("origin_mm").at(axis).get<double>(),
                        0.5);
        }
    }
    EXPECT_TRUE(found.at("perpendicularity").contains("drift_um_per_mm"));
}

TEST_F(Triple, ParallelismRefusesWhatAPictureDoesNotShow) {
    const fs::path copy = fresh_folder();
    fs::copy(folder(), copy);
    fs::copy_file(kSpots / "README.md", copy / "plate_2_spot_3.pgm", fs::copy_options::overwrite_existing);
    const Ended no_picture =
        run({"calibrate", "parallelism", (copy / "stand.toml").string(), "--out", (copy / "o.toml").string()});
    EXPECT_EQ(no_picture.code, 2);
    EXPECT_NE(no_picture.err.find("plate_2_spot_3.pgm"), std::string::npos) << no_picture.err;
    // The beams of 1 and 3 exchanged on every plate.
    for (const char* plate : {"1", "2", "3"}) {
        const std::string name = std::string("plate_") + plate + "_spot_";
        fs::copy_file(folder() / (name + "1.pgm"), copy / (name + "3.pgm"), fs::copy_options::overwrite_existing);
        fs::copy_file(folder() / (name + "3.pgm"), copy / (name + "1.pgm"), fs::copy_options::overwrite_existing);
    }
    const Ended swapped =
        run({"calibrate", "parallelism", (copy / "stand.toml").string(), "--out", (copy / "o.toml").string()});
    EXPECT_EQ(swapped.code, 2);
    EXPECT_NE(swapped.err.find("L1"), std::string::npos) << swapped.err;
    EXPECT_FALSE(fs::exists(copy / "o.toml"));
    fs::remove_all(copy);
}

TEST_F(Triple, ReferenceBettersTheAngleOfTheDrawing) {
    const json found = json::parse(reference().out);
    EXPECT_LT(found.at("angle_sigma_after_deg").get<double>(), 0.1 * found.at("angle_sigma_before_deg").get<double>());
    for (const json& station : found.at("stations")) {
        EXPECT_LT(std::abs(station.at("after_deg").get<double>()), 0.05) << station.dump();
    }
    // One known angle is half a degree off: no calibration explains that.
    const fs::path folder = fresh_folder();
    fs::create_directories(folder);
    write_file(folder / "known.csv", replaced(read_file(at("known.csv")), "72.5000,0.0030", "73.0000,0.0030"));
    const Ended wrong =
        run({"calibrate", "reference", "--readings", at("known_readings.csv"), "--known",
             (folder / "known.csv").string(), "--calibration", at("head.toml"), "--out", (folder / "o.toml").string()});
    EXPECT_NE(wrong.code, 0);
    EXPECT_FALSE(fs::exists(folder / "o.toml"));
    fs::remove_all(folder);
}

TEST_F(Triple, ABatchHasTrueAnglesAndAllThatIsAskedFor) {
    const fs::path folder = fresh_folder();
    fs::create_directories(folder);
    write_file(folder / "rail.toml", R"(format = "scribecell-measure"
version = 1
[target]
sit = "as_given"
angle_deg = 90.0
yaw_deg = 0.0
distance_mm = 300.0
[tolerance]
angle_deg = 0.2
distance_mm = 0.5
[[screw]]
id = "a"
place_mm = [0.0, 30.0]
pitch_mm = 1.0
[[screw]]
id = "b"
place_mm = [-50.0, 120.0]
pitch_mm = 1.0
[[screw]]
id = "c"
place_mm = [50.0, 120.0]
pitch_mm = 1.0
[robot]
rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
translation_mm = [1000.0, 0.0, 500.0]
rail = [0.0, 1.0, 0.0]
first_number = 1
)");
    const Ended ended = run({"measure", at("stations.csv"), "--calibration", at("whole.toml"), "--job",
                             (folder / "rail.toml").string(), "--database", (folder / "run.db").string(), "--robot-out",
                             (folder / "frames").string(), "--pictures", (folder / "pictures").string(), "--json"});
    ASSERT_EQ(ended.code, 0) << ended.out << ended.err;
    const json stations = json::parse(ended.out).at("stations");
    ASSERT_EQ(stations.size(), 7U);
    for (std::size_t k = 0; k < 7; ++k) {
        EXPECT_NEAR(stations.at(k).at("angle_deg").get<double>(), 60.0 + 5.0 * static_cast<double>(k), 0.12);
        EXPECT_EQ(stations.at(k).at("correction").at("screws").size(), 3U);
    }
    EXPECT_EQ(stations.at(0).at("correction").at("verdict"), "adjust");
    for (const char* file : {"frames.csv", "stations.src", "Stations.mod", "stations.ls"}) {
        EXPECT_GT(fs::file_size(folder / "frames" / file), 200U) << file;
    }
    EXPECT_GT(fs::file_size(folder / "run.db"), 1000U);
    EXPECT_NE(read_file(folder / "pictures/station_0007.svg").find("</svg>"), std::string::npos);
    EXPECT_TRUE(read_file(folder / "pictures/station_0007.png").starts_with("\x89PNG"));
    fs::remove_all(folder);
}

TEST_F(Triple, EachFaultHasItsOwnNameAndNoFigure) {
    const std::string plain = "station,d1_mm,d2_mm,d3_mm";
    EXPECT_EQ(problem_of(plain + ",age_ms", [](int k) { return "s," + reading(k) + ",500"; }), "stale");
    EXPECT_EQ(problem_of(plain + ",fault", [](int) { return std::string("s,,,,no echo"); }), "sensor_fault");
    EXPECT_EQ(problem_of(plain,
                         [](int k) {
                             const std::string all = "s," + reading(k);
                             return all.substr(0, all.rfind(',')) + ",245.7000";
                         }),
              "stuck");
    EXPECT_EQ(problem_of(plain, [](int k) { return "s," + reading(k, 5000.0); }), "out_of_range");
    EXPECT_EQ(problem_of(plain, [](int k) { return "s" + std::to_string(k) + "," + reading(k); }), "too_few");
    EXPECT_EQ(problem_of(plain + ",sensors", [](int k) { return "s," + reading(k) + ",L2 L1 L3"; }), "swapped_sensors");
    EXPECT_EQ(problem_of(plain + ",sensors", [](int k) { return "s," + reading(k) + ",L1 L2 X9"; }), "wrong_sensors");
    EXPECT_EQ(problem_of(plain, [](int k) { return "s," + reading(k, 250.0, 250.0, 700.0); }), "grazing");
    // The same head, calibrated without a reference in its stand.
    const std::string stand = read_file(at("stand.toml"));
    const std::size_t from = stand.find("[reference]");
    write_file(folder() / "bare.toml", stand.substr(0, from) + stand.substr(stand.find("[[height]]", from)));
    ASSERT_EQ(run({"calibrate", "parallelism", at("bare.toml"), "--out", at("bare_head.toml")}).code, 0);
    EXPECT_EQ(problem_of(plain, [](int k) { return "s," + reading(k); }, "bare_head.toml"), "missing_reference");
}

TEST_F(Triple, KnownStationsAreLookedAtFirst) {
    // Columns 1 and 3 exchanged: a single station cannot show that, a known one does.
    const fs::path folder = fresh_folder();
    fs::create_directories(folder);
    write_file(folder / "swapped.csv",
               replaced(read_file(at("known_readings.csv")), "station,d1_mm,d2_mm,d3_mm", "station,d3_mm,d2_mm,d1_mm"));
    const Ended right = run(
        {"measure", at("known_readings.csv"), "--calibration", at("whole.toml"), "--check", at("known.csv"), "--json"});
    EXPECT_EQ(right.code, 0) << right.err;
    const Ended swapped = run(
        {"measure", (folder / "swapped.csv").string(), "--calibration", at("whole.toml"), "--check", at("known.csv")});
    EXPECT_EQ(swapped.code, 1);
    EXPECT_NE(swapped.err.find("swapped_sensors"), std::string::npos) << swapped.err;
    EXPECT_EQ(swapped.out.find("90."), std::string::npos) << "no figures";
    fs::remove_all(folder);
}

/// What a page on loopback answers; "" if none does.
std::string get(int port, const std::string& path) {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    std::string answer;
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): as the sockets' interface wants it.
    if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
        const std::string request = "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
        static_cast<void>(::send(fd, request.data(), request.size(), MSG_NOSIGNAL));
        std::array<char, 4096> buffer{};
        for (ssize_t n = 0; (n = ::recv(fd, buffer.data(), buffer.size(), 0)) > 0;) {
            answer.append(buffer.data(), static_cast<std::size_t>(n));
        }
    }
    ::close(fd);
    return answer;
}

int port_of(const std::string& err) {
    const std::string before = "page: http://127.0.0.1:";
    return std::stoi(err.substr(err.find(before) + before.size()));
}

TEST_F(Triple, LiveFollowsAFileShowsAPageAndEnds) {
    const fs::path folder = fresh_folder();
    fs::create_directories(folder);
    const fs::path file = folder / "growing.csv";
    write_file(file, "station,d1_mm,d2_mm,d3_mm\n");
    Program live("scribecell", {"measure", file.string(), "--calibration", at("whole.toml"), "--live", "--most", "6"});
    ASSERT_TRUE(live.wait_for_err("page: http://127.0.0.1:")) << live.err();
    const int port = port_of(live.err() + " ");
    EXPECT_NE(get(port, "/view.svg").find("no figures"), std::string::npos);
    std::string text = read_file(file);
    for (int k = 0; k < 4; ++k) {
        text += "a wall," + reading(k) + "\n";
    }
    text += "a wall,29x,1,2\n";
    write_file(file, text);
    ASSERT_TRUE(live.wait_for_out("a wall")) << live.err();
    const std::string view = get(port, "/view.svg");
    EXPECT_NE(view.find("Front view"), std::string::npos) << view;
    EXPECT_NE(view.find("Top view"), std::string::npos);
    EXPECT_NE(view.find("a wall"), std::string::npos);
    EXPECT_NE(get(port, "/").find("view.svg"), std::string::npos);
    EXPECT_NE(get(port, "/else").find("404"), std::string::npos);
    write_file(file, text + "a wall," + reading(4) + "\na wall," + reading(5) + "\n");
    EXPECT_EQ(live.wait(), 0) << live.err();
    EXPECT_NE(live.err().find("left out"), std::string::npos) << live.err();
    fs::remove_all(folder);
}

TEST_F(Triple, LiveEndsWithoutReadings) {
    const fs::path folder = fresh_folder();
    fs::create_directories(folder);
    write_file(folder / "empty.csv", "station,d1_mm,d2_mm,d3_mm\n");
    const Ended ended =
        run({"measure", (folder / "empty.csv").string(), "--calibration", at("whole.toml"), "--live", "--idle", "0.2"});
    EXPECT_EQ(ended.code, 1);
    EXPECT_NE(ended.err.find("no reading for 0.2 s"), std::string::npos) << ended.err;
    fs::remove_all(folder);
}

TEST_F(Triple, LiveTakesTheSensorsOfACell) {
    const Ended good = run({"measure", "--link", "sim:", "--calibration", at("whole.toml"), "--live", "--most", "5"});
    EXPECT_NE(good.out.find("cell"), std::string::npos) << good.out << good.err;
    const fs::path folder = fresh_folder();
    fs::create_directories(folder);
    write_file(folder / "silent.txt", "at 0.0 sensor 2 silent\n");
    const Ended silent = run({"measure", "--link", "sim:", "--script", (folder / "silent.txt").string(),
                              "--calibration", at("whole.toml"), "--live", "--most", "4"});
    EXPECT_EQ(silent.code, 1) << silent.out << silent.err;
    EXPECT_NE(silent.out.find("sensor_fault"), std::string::npos) << silent.out << silent.err;
    EXPECT_NE(silent.out.find("sensor 2"), std::string::npos) << silent.out;
    fs::remove_all(folder);
}

TEST(VisionSpot, SaysCentreAndQualityOrWhyNot) {
    const Ended found = run({"vision", "spot", (kSpots / "t-480mm.png").string(), "--json"});
    ASSERT_EQ(found.code, 0) << found.err;
    const json spot = json::parse(found.out).at("spots").at(0);
    EXPECT_NEAR(spot.at("x_px").get<double>(), 330.5, 1.0);
    EXPECT_NEAR(spot.at("y_px").get<double>(), 355.1, 1.0);
    EXPECT_LT(spot.at("quality").at("roundness").get<double>(), 0.1);
    // A picture without a spot: even light that breaks the threshold.
    const fs::path folder = fresh_folder();
    fs::create_directories(folder);
    std::string pgm = "P5\n64 64\n255\n";
    for (int i = 0; i < 64 * 64; ++i) {
        pgm += static_cast<char>(100 + (i * 7919) % 5);
    }
    write_file(folder / "flat.pgm", pgm);
    const Ended flat = run({"vision", "spot", (folder / "flat.pgm").string(), "--json"});
    EXPECT_EQ(flat.code, 1);
    const json refused = json::parse(flat.out).at("spots").at(0);
    EXPECT_EQ(refused.at("found"), false);
    EXPECT_EQ(refused.at("problem"), "flat");
    EXPECT_FALSE(refused.contains("x_px"));
    EXPECT_EQ(run({"vision", "spot", (folder / "none.png").string()}).code, 2);
    fs::remove_all(folder);
}

json sensors_with(const std::string& script, int code, const std::string& after = "1.5") {
    const fs::path folder = fresh_folder();
    fs::create_directories(folder);
    write_file(folder / "faults.txt", script);
    const Ended ended = run({"sensors", "--json", "--after", after, "--script", (folder / "faults.txt").string()});
    EXPECT_EQ(ended.code, code) << ended.out << ended.err;
    fs::remove_all(folder);
    return json::parse(ended.out).at("sensors");
}

TEST(Sensors, EachFaultOnTheWireHasItsOwnText) {
    // Sensor 0 sees nothing while the head is retracted.
    const json well = sensors_with("", 0);
    for (std::size_t i = 1; i < well.size(); ++i) {
        EXPECT_GT(well.at(i).at("measured").get<int>(), 5) << well.at(i).dump();
    }
    // Each trouble of one sensor leaves the others measuring.
    std::vector<std::string> texts;
    for (const char* trouble : {"crc", "silent", "wrong_slave", "exception", "stale"}) {
        const json sensors = sensors_with(std::string("at 0.5 sensor 1 ") + trouble + "\n", 1, "5");
        EXPECT_NE(sensors.at(1).at("code").get<int>(), 0) << trouble;
        EXPECT_NE(sensors.at(1).at("quality"), "good") << trouble;
        EXPECT_EQ(sensors.at(3).at("code").get<int>(), 0) << trouble << sensors.dump();
        texts.push_back(sensors.at(1).at("text").get<std::string>());
    }
    for (std::size_t i = 0; i < texts.size(); ++i) {
        EXPECT_GT(texts[i].size(), 10U);
        for (std::size_t k = 0; k < i; ++k) {
            EXPECT_NE(texts[i], texts[k]);
        }
    }
}

TEST(Sensors, ReferencePrintsASeatingTableThatAJobTakes) {
    const Ended ended = run({"sensors", "--reference", "20"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_NE(ended.out.find("[seating]"), std::string::npos);
    EXPECT_NE(ended.out.find("expected_mm = ["), std::string::npos);
    EXPECT_EQ(run({"sensors", "--reference", "1"}).code, 2);
    EXPECT_EQ(run({"sensors", "--link", "tcp:127.0.0.1:1", "--script", "x"}).code, 2);
}

TEST(Sensors, AJobIsRefusedWhereItsWorkpieceSitsElsewhere) {
    const fs::path folder = fresh_folder();
    fs::create_directories(folder);
    for (const char* name : {"job.toml", "table1.csv", "calibration.toml", "face90_c.csv"}) {
        fs::copy_file(fs::path(SC_SOURCE_DIR) / "examples/ras3dm" / name, folder / name);
    }
    const Ended seat = run({"sensors", "--reference", "20"});
    std::string table = seat.out.substr(seat.out.find("[seating]"));
    const std::string job = read_file(folder / "job.toml");
    const std::size_t at = job.find("[alignment]");
    const auto scribe = [&](const std::string& name, const std::string& seating) {
        write_file(folder / name, job.substr(0, at) + seating + "\n" + job.substr(at));
        return run({"scribe", (folder / name).string(), "--face", "0", "--out", (folder / ("out_" + name)).string()});
    };
    const Ended good = scribe("good.toml", table);
    EXPECT_EQ(good.code, 0) << good.err;
    EXPECT_NE(good.err.find("checking the workpiece's seat"), std::string::npos);
    // The second laser expects the face 2 mm nearer.
    const std::size_t second = table.find(", 19");
    ASSERT_NE(second, std::string::npos) << table;
    table.replace(second, 6, ", 192.");
    const Ended bad = scribe("bad.toml", table);
    EXPECT_EQ(bad.code, 1) << bad.out;
    EXPECT_NE(bad.err.find("seat"), std::string::npos) << bad.err;
    EXPECT_EQ(json::parse(read_file(folder / "out_bad.toml/cell.json")).at("pulses"), 0);
    fs::remove_all(folder);
}

}  // namespace
}  // namespace sc::test
