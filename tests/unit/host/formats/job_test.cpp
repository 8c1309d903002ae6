// SPDX-License-Identifier: Apache-2.0
#include "host/formats/job.hpp"

#include <algorithm>

#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::line_with;
using test::replaced;
using test::slurp;
using test::TempDir;

const std::filesystem::path kExample = SC_SOURCE_DIR "/examples/ras3dm/job.toml";

void expect_bad(const std::string& text, int line, const std::string& value, const std::string& problem) {
    const TempDir dir;
    const auto path = dir.write("job.toml", text);
    expect_refusal([&] { static_cast<void>(read_job(path)); },
                   {.file = path.string(), .line = line, .value = value, .problem = problem});
}

/// The example with `from` replaced by `to`; the complaint must name the last line of `to`.
void expect_bad_edit(const std::string& from, const std::string& to, const std::string& value,
                     const std::string& problem) {
    const std::string text = replaced(slurp(kExample), from, to);
    const auto lines = static_cast<int>(std::ranges::count(to, '\n'));
    expect_bad(text, line_with(text, to) + lines, value, problem);
}

/// The example with tables at its end.
std::string with_tables(const std::string& tables) { return slurp(kExample) + tables; }

TEST(ReadJob, SurfaceAndSeatingAreOffUnlessAskedFor) {
    const Job job = read_job(kExample);
    EXPECT_FALSE(job.surface);
    EXPECT_FALSE(job.seating);
}

TEST(ReadJob, ReadsSurfaceAndSeating) {
    const TempDir dir;
    const auto path = dir.write("job.toml", with_tables("[surface]\nmode = \"follow\"\nwindow_mm = 2.0\n"
                                                        "bound_mm = 0.5\n[seating]\nexpected_mm = [180.1, 190.2, "
                                                        "200.3]\ntolerance_mm = 0.2\ntilt_mm = 0.3\nsamples = 20\n"));
    const Job job = read_job(path);
    ASSERT_TRUE(job.surface);
    EXPECT_TRUE(job.surface->follow);
    EXPECT_DOUBLE_EQ(job.surface->window.si(), 2e-3);
    EXPECT_DOUBLE_EQ(job.surface->bound.si(), 5e-4);
    ASSERT_TRUE(job.seating);
    EXPECT_DOUBLE_EQ(job.seating->expected.at(1), 0.1902);
    EXPECT_DOUBLE_EQ(job.seating->tolerance.si(), 2e-4);
    EXPECT_DOUBLE_EQ(job.seating->tilt.si(), 3e-4);
    EXPECT_EQ(job.seating->samples, 20);
    const auto check = dir.write("check.toml", with_tables("[surface]\nmode = \"check\"\nwindow_mm = 2.0\n"));
    EXPECT_FALSE(read_job(check).surface->follow);
}

TEST(ReadJob, RefusesSurfaceAndSeatingThatMakeNoSense) {
    const auto bad = [](const std::string& tables) {
        const TempDir dir;
        const auto path = dir.write("job.toml", with_tables(tables));
        EXPECT_THROW(static_cast<void>(read_job(path)), InputError) << tables;
    };
    const std::string seating = "[seating]\nexpected_mm = [180.1, 190.2, 200.3]\n";
    bad("[surface]\nmode = \"guess\"\nwindow_mm = 2.0\n");
    bad("[surface]\nmode = \"check\"\n");
    bad("[surface]\nmode = \"check\"\nwindow_mm = 500.0\n");
    bad("[surface]\nmode = \"check\"\nwindow_mm = 2.0\nbound_mm = 0.5\n");
    bad("[surface]\nmode = \"follow\"\nwindow_mm = 2.0\n");
    bad("[seating]\nexpected_mm = [180.1, 190.2]\ntolerance_mm = 0.2\ntilt_mm = 0.3\n");
    bad("[seating]\nexpected_mm = [180.1, -190.2, 200.3]\ntolerance_mm = 0.2\ntilt_mm = 0.3\n");
    bad(seating + "tolerance_mm = 0.2\n");
    bad(seating + "tolerance_mm = 0.2\ntilt_mm = 0.3\nsamples = 0\n");
    bad(seating + "tolerance_mm = 0.2\ntilt_mm = 0.3\nsample = 10\n");
}

TEST(ReadJob, ReadsTheExample) {
    const Job job = read_job(kExample);
    EXPECT_EQ(job.name, "ras3dm");
    EXPECT_EQ(job.table, kExample.parent_path() / "table1.csv");
    EXPECT_EQ(job.calibration, kExample.parent_path() / "calibration.toml");
    ASSERT_TRUE(job.cross);
    EXPECT_EQ(job.cross->size, Length::from_si(4e-3));
    EXPECT_EQ(job.cross->settings.actuator, Actuator::galvo);
    EXPECT_EQ(job.cross->settings.speed, Speed::from_si(0.25));
    EXPECT_EQ(job.cross->settings.pitch, Length::from_si(20.0 / 1e6));
    EXPECT_EQ(job.cross->settings.energy, Energy::from_si(300.0 / 1e6));
    EXPECT_EQ(job.cross->settings.passes, 1);
    EXPECT_EQ(job.cross->settings.tolerance, Length::from_si(5e-6)) << "the default";
    ASSERT_TRUE(job.datum_line);
    EXPECT_EQ(job.datum_line->length, Length::from_si(0.06));
    EXPECT_EQ(job.datum_line->settings.actuator, Actuator::axes);
    EXPECT_TRUE(job.c_from_w);
    ASSERT_EQ(job.faces.size(), 4U);
    EXPECT_TRUE(job.faces[0].points.empty());
    EXPECT_EQ(job.faces[0].frame, PlaceFrame::h);
    EXPECT_EQ(job.faces[1].angle_deg, 90.0);
    EXPECT_EQ(job.faces[1].frame, PlaceFrame::c);
    EXPECT_EQ(job.faces[1].points, kExample.parent_path() / "face90_c.csv");
    ASSERT_TRUE(job.faces[1].datum_line);
    EXPECT_EQ(job.faces[1].datum_line->frame, PlaceFrame::w);
    EXPECT_GT(job.faces[1].datum_line->line, job.faces[1].line);
}

TEST(ReadJob, TakesSettingsFromARecipeAndItsOwnKeysBefore) {
    const TempDir dir;
    dir.write("steel.toml",
              "format = \"scribecell-recipe\"\nversion = 1\nname = \"n\"\nmaterial = \"m\"\n"
              "[[entry]]\nid = \"seen\"\nactuator = \"galvo\"\nspeed_mm_s = 250\npitch_um = 20\nenergy_uj = 300\n"
              "width_um = 160\nfill = \"hatch\"\nfill_step_um = 80\n");
    const std::string head =
        "format = \"scribecell-job\"\nversion = 1\nname = \"j\"\ncalibration = \"c.toml\"\nrecipe = \"steel.toml\"\n";
    const std::string path = "[[path]]\nface_deg = 0\nframe = \"h\"\npoints_mm = [[0,0,0],[1,0,0]]\n";
    const Job job = read_job(dir.write("job.toml", head + path + "entry = \"seen\"\npasses = 2\nenergy_uj = 100\n"));
    const MarkSettings& s = job.paths.at(0).settings;
    EXPECT_EQ(s.actuator, Actuator::galvo);
    EXPECT_EQ(s.speed, Speed::from_si(0.25));
    EXPECT_EQ(s.energy, Energy::from_si(100.0 / 1e6)) << "its own";
    EXPECT_EQ(s.passes, 2);
    EXPECT_EQ(s.width, Length::from_si(160.0 / 1e6));
    EXPECT_EQ(s.fill_step, Length::from_si(80.0 / 1e6));
    const Job thin = read_job(dir.write("thin.toml", head + path + "entry = \"seen\"\nwidth_um = 0\n"));
    EXPECT_EQ(thin.paths.at(0).settings.width, Length{});
    expect_refusal([&] { static_cast<void>(read_job(dir.write("b.toml", head + path + "entry = \"deep\"\n"))); },
                   {.file = (dir / "b.toml").string(), .line = 10, .value = "deep", .problem = "is not in the recipe"});
    const std::string without = replaced(head, "recipe = \"steel.toml\"\n", "");
    expect_refusal([&] { static_cast<void>(read_job(dir.write("b.toml", without + path + "entry = \"seen\"\n"))); },
                   {.file = (dir / "b.toml").string(), .line = 9, .value = "seen", .problem = "the job has no recipe"});
}

TEST(ReadJob, RefusesAMissingFileAndBadToml) {
    expect_refusal([] { static_cast<void>(read_job("no/job.toml")); },
                   {.file = "no/job.toml", .problem = "no such file"});
    expect_bad("", 0, "format", "key is missing");
    expect_bad("format = \n", 1, "format =", "is not TOML");
    expect_bad_edit("size_mm = 4.0", "size_mm = 4,0", "size_mm = 4,0", "decimal comma");
    expect_bad_edit("[cross]", "[cross", "[cross", "is not TOML");
}

TEST(ReadJob, RefusesAnotherFormatAndANewerVersion) {
    expect_bad_edit("scribecell-job", "scribecell-part", "scribecell-part", "another kind of file");
    expect_bad_edit("version = 1", "version = 2", "2", "newer than this program");
    expect_bad_edit("version = 1", "version = \"1\"", "1", "not a whole number");
}

TEST(ReadJob, NamesMissingKeys) {
    const std::string good = slurp(kExample);
    expect_bad(replaced(good, "name = \"ras3dm\"\n", ""), 0, "name", "key is missing");
    expect_bad(replaced(good, "table = \"table1.csv\"\n", ""), 0, "table", "key is missing");
    expect_bad(replaced(good, "calibration = \"calibration.toml\"\n", ""), 0, "calibration", "key is missing");
    expect_bad(replaced(good, "size_mm = 4.0\n", ""), line_with(good, "[cross]"), "cross.size_mm", "key is missing");
    expect_bad(replaced(good, "frame = \"h\"\n", ""), line_with(good, "[[face]]"), "face.frame", "key is missing");
    expect_bad(good.substr(0, good.find("[[face]]")), 0, "face", "key is missing");
}

TEST(ReadJob, NamesUnknownAndRepeatedKeys) {
    expect_bad_edit("size_mm = 4.0", "size_mm = 4.0\nsise_mm = 4.0", "cross.sise_mm", "unknown key");
    const std::string text = replaced(slurp(kExample), "table = ", "colour = \"red\"\ntable = ");
    expect_bad(text, line_with(text, "colour"), "colour", "unknown key");
    const std::string twice = replaced(slurp(kExample), "table = ", "name = \"again\"\ntable = ");
    expect_bad(twice, line_with(twice, "name = \"again\""), "name = \"again\"", "is not TOML");
}

TEST(ReadJob, NamesBadValues) {
    expect_bad_edit("size_mm = 4.0", "size_mm = \"4.0\"", "4.0", "cross.size_mm is not a number");
    expect_bad_edit("size_mm = 4.0", "size_mm = nan", "nan", "not a finite number");
    expect_bad_edit("size_mm = 4.0", "size_mm = -inf", "-inf", "not a finite number");
    expect_bad_edit("size_mm = 4.0", "size_mm = -4.0", "-4.0", "out of range");
    expect_bad_edit("speed_mm_s = 250.0", "speed_mm_s = 0.0", "0.0", "out of range");
    expect_bad_edit("passes = 1", "passes = 0", "0", "out of range");
    expect_bad_edit("passes = 1", "passes = 256", "256", "out of range");
    expect_bad_edit("actuator = \"galvo\"", "actuator = \"mirror\"", "mirror", "unknown value");
    expect_bad_edit("frame = \"h\"", "frame = \"H\"", "H", "unknown value");
    expect_bad_edit("points = \"face90_c.csv\"", "points = 7", "7", "not a text");
    expect_bad_edit("[cross]\nsize_mm = 4.0", "[cross]\nsize_mm = [4.0]", "a list", "not a number");
}

TEST(ReadJob, RefusesAMirrorAndWhatIsNoRotation) {
    const std::string good = slurp(kExample);
    const int line = line_with(good, "rotation = [");
    const std::string row = "[0.784392369711, 0.007221264242, 0.620222914509]";
    const std::string mirrored = replaced(good, row, "[-0.784392369711, -0.007221264242, -0.620222914509]");
    const std::string skewed = replaced(good, row, "[0.7844, 0.0072, 0.6202]");
    const TempDir dir;
    for (const auto& [text, word] : {std::pair{mirrored, "left-handed"}, std::pair{skewed, "not orthonormal"}}) {
        try {
            static_cast<void>(read_job(dir.write("job.toml", text)));
            FAIL() << word;
        } catch (const InputError& error) {
            EXPECT_NE(error.problem().find(word), std::string::npos) << error.what();
            EXPECT_EQ(error.line(), line);
            EXPECT_FALSE(error.value().empty());
        }
    }
}

TEST(ReadJob, RefusesWhatContradictsItself) {
    expect_bad_edit("angle_deg = 180.0", "angle_deg = 90 # again", "90.0", "appears twice");
    const std::string good = slurp(kExample);
    expect_bad(replaced(good, "frame = \"h\"", "frame = \"c\""), line_with(good, "frame = \"h\""), "c",
               "does not suit the table");
    const std::size_t from = good.find("# c_from_w");
    std::string text = good;
    text.erase(from, good.find("[[face]]") - from);
    expect_bad(text, line_with(text, "[face.line]"), "w", "needs the workpiece's place");
    text = good;
    const std::size_t cross = good.find("[cross]");
    text.erase(cross, good.find("# c_from_w") - cross);
    expect_bad(text, 0, "cross", "key is missing");
}

TEST(ReadJob, RefusesALineWithoutLength) {
    const std::string good = slurp(kExample);
    const std::string from =
        good.substr(good.find("from_mm"), good.find('\n', good.find("from_mm")) - good.find("from_mm"));
    const std::string to = good.substr(good.find("to_mm"), good.find('\n', good.find("to_mm")) - good.find("to_mm"));
    const std::string text = replaced(good, to, replaced(from, "from_mm", "to_mm"));
    expect_bad(text, line_with(text, "to_mm"), "169.6523", "makes no line");
}

const std::string kPathJob = R"(format = "scribecell-job"
version = 1
name = "rim"
calibration = "calibration.toml"
[[path]]
name = "rim"
face_deg = 90.0
frame = "h"
points_mm = [
    [-260.0, -300.0, -400.0],
    { via = [-250.0, -300.0, -390.0], to = [-240.1, -300.0, -400.0] },
    [-230.0, -300.0, -400.0],
]
arc_fit = 0.25
actuator = "axes"
speed_mm_s = 60.0
pitch_um = 20.0
energy_uj = 300.0
[[path]]
face_deg = 0.0
frame = "h"
file = "line.csv"
actuator = "galvo"
speed_mm_s = 60.0
pitch_um = 20.0
energy_uj = 300.0
)";

TEST(ReadJob, ReadsFreePathsAloneAndWritesThem) {
    const TempDir dir;
    const Job job = read_job(dir.write("job.toml", kPathJob));
    EXPECT_TRUE(job.faces.empty());
    ASSERT_EQ(job.paths.size(), 2U);
    const JobPath& rim = job.paths[0];
    EXPECT_EQ(rim.line, 5);
    EXPECT_EQ(rim.face_deg, 90.0);
    EXPECT_EQ(rim.arc_fit, 0.25);
    ASSERT_EQ(rim.steps.size(), 3U);
    EXPECT_FALSE(rim.steps[0].via);
    EXPECT_EQ(rim.steps[1], (PathStep{11, Vec3{-250.0 / 1e3, -0.3, -390.0 / 1e3}, {-240.1 / 1e3, -0.3, -0.4}}));
    EXPECT_EQ(job.paths[1].name, "path 2");
    EXPECT_EQ(job.paths[1].file.filename(), "line.csv");
    EXPECT_EQ(job.paths[1].arc_fit, 0.0) << "off by default";
    write_job(dir / "again.toml", job);
    const Job again = read_job(dir / "again.toml");
    ASSERT_EQ(again.paths.size(), 2U);
    EXPECT_EQ(again.paths[0].settings, rim.settings);
    EXPECT_EQ(again.paths[0].arc_fit, rim.arc_fit);
    ASSERT_EQ(again.paths[0].steps.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(again.paths[0].steps[i].via, rim.steps[i].via);
        EXPECT_EQ(again.paths[0].steps[i].to, rim.steps[i].to);
    }
    EXPECT_EQ(again.paths[1].file.filename(), "line.csv");
}

TEST(ReadJob, RefusesBadFreePaths) {
    const auto bad = [](const std::string& from, const std::string& to, int line, const std::string& value,
                        const std::string& problem) { expect_bad(replaced(kPathJob, from, to), line, value, problem); };
    bad("{ via = [-250.0, -300.0, -390.0], to", "{ wia = [-250.0, -300.0, -390.0], to", 11, "path.points_mm.via",
        "key is missing");
    bad("    [-260.0, -300.0, -400.0],\n", "", 9, "via", "begins with an arc");
    bad("[-260.0, -300.0, -400.0]", "[-260.0, -300.0]", 10, "a list", "is no place");
    bad("[-260.0, -300.0, -400.0]", "[-260.0, \"a\", -400.0]", 9, "a", "not a number");
    bad("arc_fit = 0.25", "arc_fit = 0.95", 14, "0.95", "out of range");
    bad("face_deg = 0.0", "face_deg = 0.0\nname = \"rim\"", 21, "rim", "appears twice");
    bad("face_deg = 0.0", "face_deg = 0.0\npoints_mm = []", 21, "file", "besides a file");
    bad("frame = \"h\"", "frame = \"w\"", 5, "w", "needs the workpiece's place");
}

TEST(WriteJob, RoundTripsInAnotherFolder) {
    const TempDir dir;
    std::filesystem::create_directories(dir / "sub");
    const auto path = (dir / "sub") / "copy.toml";
    const Job job = read_job(kExample);
    write_job(path, job);
    const Job again = read_job(path);
    EXPECT_EQ(again.name, job.name);
    EXPECT_EQ(std::filesystem::weakly_canonical(again.table), std::filesystem::weakly_canonical(job.table));
    EXPECT_EQ(again.cross, job.cross);
    EXPECT_EQ(again.datum_line, job.datum_line);
    EXPECT_EQ(again.c_from_w, job.c_from_w);
    ASSERT_EQ(again.faces.size(), job.faces.size());
    for (std::size_t i = 0; i < job.faces.size(); ++i) {
        EXPECT_EQ(again.faces[i].angle_deg, job.faces[i].angle_deg);
        EXPECT_EQ(again.faces[i].frame, job.faces[i].frame);
        EXPECT_EQ(std::filesystem::weakly_canonical(again.faces[i].points),
                  std::filesystem::weakly_canonical(job.faces[i].points));
        ASSERT_EQ(again.faces[i].datum_line.has_value(), job.faces[i].datum_line.has_value());
    }
    EXPECT_EQ(again.faces[1].datum_line->from, job.faces[1].datum_line->from);
    EXPECT_EQ(again.faces[1].datum_line->to, job.faces[1].datum_line->to);
}

TEST(WriteJob, WritesNothingThatWouldBeRefused) {
    const TempDir dir;
    Job job = read_job(kExample);
    job.faces.clear();
    EXPECT_THROW(write_job(dir / "job.toml", job), InputError);
    EXPECT_EQ(dir.files(), 0U);
}

}  // namespace
}  // namespace sc::host
