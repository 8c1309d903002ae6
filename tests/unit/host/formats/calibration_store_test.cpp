// SPDX-License-Identifier: Apache-2.0
#include "host/formats/calibration_store.hpp"

#include <cstdlib>

#include "host/formats/job.hpp"
#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::slurp;
using test::TempDir;

const std::filesystem::path kExample = SC_SOURCE_DIR "/examples/ras3dm/calibration.toml";

/// The example with another id, sealed.
std::filesystem::path other_set(const TempDir& dir, const std::string& id) {
    CalibrationSet set = read_calibration(kExample);
    set.parents = {set.id};
    set.id = id;
    set.transforms[0].translation.x += 1e-5;
    static_cast<void>(write_calibration(dir / (id + ".toml"), set));
    return dir / (id + ".toml");
}

TEST(CalibrationStore, KeepsEverySetAndWhatWasCurrent) {
    const TempDir dir;
    CalibrationStore store(dir / "store");
    EXPECT_EQ(store.current(), nullptr);
    EXPECT_EQ(dir.files(), 0U) << "looking at a store makes nothing";
    const std::string first = store.import(kExample, "", "").sha256;
    EXPECT_EQ(store.current()->no, 1);
    EXPECT_EQ(slurp(store.file_of(*store.current())), slurp(kExample)) << "byte for byte";
    store.import(other_set(dir, "second"), "", "new lens");
    EXPECT_EQ(store.current()->no, 2);
    store.import(kExample, "", "again");
    EXPECT_EQ(store.sets().size(), 2U) << "the same content is one set";
    EXPECT_EQ(store.current()->no, 1);
    store.rollback("", "");
    EXPECT_EQ(store.current()->id, "second");
    store.rollback(first.substr(0, 8), "worse");

    const CalibrationStore again(dir / "store");
    EXPECT_EQ(again.sets(), store.sets());
    EXPECT_EQ(again.changes(), store.changes());
    ASSERT_EQ(again.changes().size(), 5U);
    EXPECT_EQ(again.changes()[1].note, "new lens");
    EXPECT_EQ(again.changes()[4].what, "rollback");
    EXPECT_EQ(again.changes()[4].from, 2);
    EXPECT_EQ(again.current()->no, 1);
    EXPECT_EQ(again.find("second").no, 2);
    EXPECT_EQ(again.find("2").no, 2);
    EXPECT_EQ(again.find("").no, 1);
    for (const char* name : {"3", "0", "nobody", "abcdef012345"}) {
        EXPECT_THROW(static_cast<void>(again.find(name)), InputError) << name;
    }
}

TEST(CalibrationStore, RefusesWithoutATrace) {
    const TempDir dir;
    CalibrationStore store(dir / "store");
    EXPECT_THROW(store.rollback("", ""), InputError);
    const auto damaged = dir.write(
        "damaged.toml", test::replaced(slurp(kExample), "squareness_xy_mrad = 0.1219", "squareness_xy_mrad = 0.1220"));
    EXPECT_THROW(store.import(damaged, "", ""), InputError);
    EXPECT_THROW(store.import(kExample, std::string(64, '0'), ""), InputError);
    EXPECT_THROW(store.import(dir / "missing.toml", "", ""), InputError);
    EXPECT_FALSE(std::filesystem::exists(dir / "store"));
    store.import(kExample, read_calibration(kExample).sha256, "");
    EXPECT_THROW(store.rollback("", ""), InputError) << "there is no earlier one";
    EXPECT_EQ(store.changes().size(), 1U);
    dir.write("store/store.toml", slurp(dir / "store/store.toml") + "[[change]]\nto = 7\n");
    EXPECT_THROW(CalibrationStore(dir / "store"), InputError);
}

TEST(CalibrationStore, RollsBackToNothingThatWasChanged) {
    const TempDir dir;
    CalibrationStore store(dir / "store");
    const StoredSet first = store.import(kExample, "", "");
    store.import(other_set(dir, "second"), "", "");
    std::string text = slurp(store.file_of(first));
    text = text.erase(text.find("sha256"), text.find('\n', text.find("sha256")) + 1 - text.find("sha256"));
    dir.write("store/sets/" + first.sha256 + ".toml", test::replaced(text, "0.1219", "0.1220"));
    EXPECT_THROW(store.rollback("1", ""), InputError);
    EXPECT_EQ(CalibrationStore(dir / "store").current()->no, 2);
    store.import(kExample, "", "");
    EXPECT_EQ(slurp(store.file_of(first)), slurp(kExample)) << "importing makes a damaged file good";
}

TEST(CalibrationStore, StandsInForAFileByName) {
    const TempDir dir;
    ::setenv("SCRIBECELL_STORE", (dir / "store").c_str(), 1);
    EXPECT_THROW(static_cast<void>(read_calibration("store:")), InputError) << "it is empty";
    CalibrationStore store(CalibrationStore::default_folder());
    store.import(kExample, "", "");
    store.import(other_set(dir, "second"), "", "");
    EXPECT_EQ(read_calibration("store:").id, "second");
    EXPECT_EQ(read_calibration("store:1").id, "reference-cell-1");
    EXPECT_EQ(read_calibration("store:1").file, store.file_of(store.find("1")));
    const std::filesystem::path examples = SC_SOURCE_DIR "/examples/ras3dm";
    const auto job =
        dir.write("job.toml", test::replaced(slurp(examples / "job.toml"), "\"calibration.toml\"", "\"store:\""));
    EXPECT_EQ(read_job(job).calibration, "store:");
    write_job(dir / "again.toml", read_job(job));
    EXPECT_EQ(read_job(dir / "again.toml").calibration, "store:");
    ::unsetenv("SCRIBECELL_STORE");
}

}  // namespace
}  // namespace sc::host
