// SPDX-License-Identifier: Apache-2.0
#include "host/formats/csv.hpp"

#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;

void parse_and_read(std::string_view text) {
    const CsvTable csv = CsvTable::parse("t.csv", text);
    for (std::size_t row = 0; row < csv.size(); ++row) {
        for (std::size_t column = 0; column < csv.columns().size(); ++column) {
            static_cast<void>(csv.number(row, column));
        }
    }
}

void expect_bad(std::string_view text, int line, const std::string& value, const std::string& problem) {
    expect_refusal([&] { parse_and_read(text); }, {.file = "t.csv", .line = line, .value = value, .problem = problem});
}

TEST(CsvTable, ReadsByNameWithLineNumbers) {
    const CsvTable csv = CsvTable::parse("t.csv", "\xEF\xBB\xBF# made by hand\nb, a\r\n\n 1.5,\t-2e-3 \r\n+3,4");
    EXPECT_EQ(csv.columns(), (std::vector<std::string>{"b", "a"}));
    ASSERT_EQ(csv.size(), 2U);
    EXPECT_EQ(csv.line(0), 4);
    EXPECT_EQ(csv.line(1), 5);
    EXPECT_EQ(csv.number(0, csv.column("a")), -2e-3);
    EXPECT_EQ(csv.number(0, csv.column("b")), 1.5);
    EXPECT_EQ(csv.integer(1, csv.column("b")), 3);
    EXPECT_TRUE(csv.has("a"));
    EXPECT_FALSE(csv.has("c"));
}

TEST(CsvTable, AHeaderAloneIsATableWithoutRows) { EXPECT_EQ(CsvTable::parse("t.csv", "x,y\n").size(), 0U); }

TEST(CsvTable, RefusesAnEmptyFile) {
    for (const std::string_view text : {"", "\n\r\n", "# only a comment\n", "\xEF\xBB\xBF"}) {
        expect_bad(text, 0, "", "is empty");
    }
}

TEST(CsvTable, NamesAMissingColumnAndThosePresent) {
    const CsvTable csv = CsvTable::parse("t.csv", "# comment\nx,z\n1,2\n");
    try {
        static_cast<void>(csv.column("y"));
        FAIL();
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), "t.csv:2: column is missing: y; the columns present are x, z");
    }
}

TEST(CsvTable, NamesAnUnknownColumn) {
    const CsvTable csv = CsvTable::parse("t.csv", "x,ycoord\n");
    expect_refusal([&] { csv.refuse_columns_beyond({"x", "y"}); },
                   {.file = "t.csv", .line = 1, .value = "ycoord", .problem = "unknown column"});
}

TEST(CsvTable, RefusesRepeatedAndNamelessColumns) {
    expect_bad("x,y,x\n", 1, "x", "twice");
    expect_bad("x,,y\n", 1, "x,,y", "no name");
}

TEST(CsvTable, NamesTextForANumber) {
    expect_bad("x,y\n1,2\n3,abc\n", 3, "abc", "column y is not a number");
    expect_bad("x\n0x10\n", 2, "0x10", "not a number");
    expect_bad("x\n1.2.3\n", 2, "1.2.3", "not a number");
    expect_bad("x\n1e999\n", 2, "1e999", "not a number");
    expect_bad("x\n+-1\n", 2, "+-1", "not a number");
    expect_bad("x,y\n,1\n", 2, "", "column x is empty");
}

TEST(CsvTable, NamesNotANumberAndInfinity) {
    for (const std::string value : {"nan", "NaN", "-nan", "nan(1)", "inf", "-Infinity", "+INF"}) {
        expect_bad("x\n" + value + "\n", 2, value, "not a finite number");
    }
}

TEST(CsvTable, NamesADecimalComma) {
    expect_bad("x,y\n\"12,5\",1\n", 2, "12,5", "decimal comma");
    expect_bad("x,y\n1.0,2.0\n12,5,13,5\n", 3, "12,5,13,5", "row has 4 fields where the header names 2, as numbers");
}

TEST(CsvTable, NamesSemicolons) {
    expect_bad("x;y\n12,5;13,5\n", 1, "x;y", "semicolons");
    expect_bad("x,y\n12.5;13.5\n", 2, "12.5;13.5", "semicolons");
}

TEST(CsvTable, RefusesAShortRow) { expect_bad("x,y,z\n1,2\n", 2, "1,2", "row has 2 fields where the header names 3"); }

TEST(CsvTable, RefusesAFractionWhereAWholeNumberIsMeant) {
    const CsvTable csv = CsvTable::parse("t.csv", "no\n1.5\n1e12\n");
    expect_refusal([&] { static_cast<void>(csv.integer(0, 0)); },
                   {.file = "t.csv", .line = 2, .value = "1.5", .problem = "not a whole number"});
    expect_refusal([&] { static_cast<void>(csv.integer(1, 0)); },
                   {.file = "t.csv", .line = 3, .value = "1e12", .problem = "not a whole number"});
}

TEST(CsvTable, ShortensAndCleansWhatItQuotes) {
    const std::string long_field(500, 'a');
    try {
        parse_and_read("x\n\x01" + long_field + "\n");
        FAIL();
    } catch (const InputError& error) {
        EXPECT_EQ(error.value(), "?" + std::string(59, 'a') + "...");
    }
}

TEST(ParseNumber, TakesTheWholeTextOrNothing) {
    double value = 7.0;
    EXPECT_TRUE(parse_number("-0.25e1", value));
    EXPECT_EQ(value, -2.5);
    for (const std::string_view text : {"", " 1", "1 ", "1,5", "-", "+", ".", "nan", "inf", "1e400"}) {
        EXPECT_FALSE(parse_number(text, value)) << text;
        EXPECT_EQ(value, -2.5) << text;
    }
}

}  // namespace
}  // namespace sc::host
