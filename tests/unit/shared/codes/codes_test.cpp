// SPDX-License-Identifier: Apache-2.0
#include "shared/codes/codes.hpp"

#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace {

using namespace sc;

std::string read_text(const std::string& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

std::string table_of(const std::string& title, std::uint16_t first, std::uint16_t last) {
    std::string out = "\n## " + title + "\n\n| number | name | what is wrong | what to do |\n|---|---|---|---|\n";
    for (const CodeText& row : code_list()) {
        if (row.number >= first && row.number <= last) {
            out += "| " + std::to_string(row.number) + " | `" + std::string(row.name) + "` | " + std::string(row.text) +
                   " | " + std::string(row.action) + " |\n";
        }
    }
    return out;
}

/// docs/codes.md as the list in the code would have it.
std::string codes_page() {
    return "# Codes\n\n"
           "Every fault, refusal and \"limited by\" of the cell, with its number. Numbers are never reused. This page "
           "is "
           "made from\n`shared/codes/codes.cpp`; the test `Codes.PageInDocsListsEveryCode` compares the two.\n" +
           table_of("Faults: laser off, axes stopped, latched until reset", 1, 63) +
           table_of("Refusals: nothing was done, nothing has changed", 100, 199) +
           table_of("Limited by: what holds the speed down; no error", 200, 219) +
           table_of("Sensors: why a distance sensor has no good value", 300, 319);
}

TEST(Codes, PageInDocsListsEveryCode) {
    const std::string expected = codes_page();
    const std::string written = SC_BINARY_DIR "/codes.md";
    std::ofstream(written) << expected;
    EXPECT_EQ(read_text(SC_SOURCE_DIR "/docs/codes.md"), expected)
        << "docs/codes.md is not what the list says; take over the page just written: cp " << written
        << " docs/codes.md";
}

TEST(Codes, NumbersAndNamesAreUnique) {
    std::set<std::uint16_t> numbers;
    std::set<std::string_view> names;
    for (const CodeText& row : code_list()) {
        EXPECT_TRUE(numbers.insert(row.number).second) << row.number;
        EXPECT_TRUE(names.insert(row.name).second) << row.name;
    }
}

TEST(Codes, EveryFaultAndRefusalSaysWhatIsWrongAndWhatToDo) {
    for (const CodeText& row : code_list()) {
        EXPECT_FALSE(row.text.empty()) << row.name;
        if (row.number < 200 || row.number >= 300) {
            EXPECT_FALSE(row.action.empty()) << row.name;
        }
    }
}

TEST(Codes, EveryNumberLiesInTheRangeOfItsKind) {
    for (const CodeText& row : code_list()) {
        const bool fault = row.number >= 1 && row.number <= 63;
        const bool refusal = row.number >= 100 && row.number <= 199;
        const bool limit = row.number >= 200 && row.number <= 219;
        const bool sensor = row.number >= 300 && row.number <= 319;
        EXPECT_TRUE(fault || refusal || limit || sensor) << row.number;
    }
}

TEST(Codes, FindCodeGivesTheRowOfEachNumberAndNothingForOthers) {
    unsigned found = 0;
    for (unsigned number = 0; number <= 0xFFFF; ++number) {
        const CodeText* row = find_code(static_cast<std::uint16_t>(number));
        if (row != nullptr) {
            EXPECT_EQ(row->number, number);
            ++found;
        }
    }
    EXPECT_EQ(found, code_list().size());
}

TEST(Codes, FindCodeByEnumeratorGivesItsRow) {
    ASSERT_NE(find_code(Fault::encoder_frozen), nullptr);
    EXPECT_EQ(find_code(Fault::encoder_frozen)->name, "encoder_frozen");
    ASSERT_NE(find_code(Refusal::out_of_travel), nullptr);
    EXPECT_EQ(find_code(Refusal::out_of_travel)->name, "out_of_travel");
    ASSERT_NE(find_code(LimitedBy::corner), nullptr);
    EXPECT_EQ(find_code(LimitedBy::corner)->name, "corner");
    EXPECT_EQ(find_code(Fault::none), nullptr);
    EXPECT_EQ(find_code(Refusal::none), nullptr);
}

TEST(Codes, EachFaultHasItsOwnBit) {
    std::uint64_t all = 0;
    unsigned faults = 0;
    for (const CodeText& row : code_list()) {
        if (row.number < 64) {
            const std::uint64_t bit = fault_bit(static_cast<Fault>(row.number));
            EXPECT_EQ(all & bit, 0U) << row.name;
            all |= bit;
            ++faults;
        }
    }
    EXPECT_EQ(__builtin_popcountll(all), static_cast<int>(faults));
    EXPECT_EQ(all & fault_bit(Fault::none), 0U);
}

}  // namespace
