// SPDX-License-Identifier: Apache-2.0
// docs/link.md against the code: the tables of messages, and the numbers that a reader would rely on.
#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "shared/link/blackbox.hpp"
#include "shared/link/codec.hpp"
#include "shared/link/schema.hpp"
#include "shared/link/telemetry.hpp"

namespace {

using namespace sc::link;  // NOLINT(google-build-using-namespace): the subject of this file

struct FieldLister {
    std::string fields;
    template <class T>
    void operator()(std::string_view name, const T& /*value*/) {
        const FieldType type = FieldTypeOf<T>::value;
        fields += fields.empty() ? "" : ", ";
        fields += std::string(name) + " " + std::string(type.base);
        if (type.count > 0) {
            fields += "[" + std::to_string(type.count) + "]";
        }
    }
};

std::vector<std::string> rows_of_the_code() {
    std::vector<std::string> rows;
    const auto add = [&rows](const auto& message) {
        FieldLister lister;
        message.visit(lister, message);
        rows.push_back("| " + std::to_string(unsigned{message.kId}) + " | " + std::string(message.kName) + " | " +
                       lister.fields + " |");
    };
    for_each_message(HostMessages{}, add);
    for_each_message(CellMessages{}, add);
    return rows;
}

std::vector<std::string> lines_of_the_page() {
    std::ifstream file(SC_SOURCE_DIR "/docs/link.md");
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) {
        lines.push_back(line);
    }
    return lines;
}

std::string hex(std::uint64_t value) {
    std::ostringstream out;
    out << "`0x" << std::hex;
    out.width(16);
    out.fill('0');
    out << value << "`";
    return out.str();
}

TEST(LinkPage, ListsEveryMessageWithItsFieldsAndNoOther) {
    std::vector<std::string> rows;
    for (const std::string& line : lines_of_the_page()) {
        if (line.size() > 2 && line.starts_with("| ") && std::isdigit(static_cast<unsigned char>(line[2])) != 0) {
            rows.push_back(line);
        }
    }
    EXPECT_EQ(rows, rows_of_the_code());
}

TEST(LinkPage, ListsTheChannelsOfTelemetryAndTheEventsOfTheBlackBox) {
    const std::vector<std::string> lines = lines_of_the_page();
    const auto has = [&lines](const std::string& begin) {
        return std::ranges::any_of(lines, [&](const std::string& line) { return line.starts_with(begin); });
    };
    for (std::size_t i = 0; i < kTelemetryColumns.size(); ++i) {
        const TelemetryColumn& c = kTelemetryColumns[i];
        const std::string type = (c.sign ? "i" : "u") + std::to_string(8U * c.bytes) +
                                 (c.count > 1 ? "[" + std::to_string(unsigned{c.count}) + "]" : "");
        const std::string row = "| " + std::string(c.name) + " | " + std::to_string(i) + " | " +
                                std::string(kTelemetryGroups[static_cast<std::size_t>(c.group)]) + " | " + type + " |";
        EXPECT_TRUE(has(row)) << row;
    }
    for (unsigned kind = 1; name_of(static_cast<BlackboxKind>(kind)) != "unknown"; ++kind) {
        const std::string row =
            "| " + std::string(name_of(static_cast<BlackboxKind>(kind))) + " | " + std::to_string(kind) + " |";
        EXPECT_TRUE(has(row)) << row;
    }
}

TEST(LinkPage, StatesTheHashesAndSizesOfTheCode) {
    std::string page;
    for (const std::string& line : lines_of_the_page()) {
        page += line + "\n";
    }
    const auto says = [&page](const std::string& text) { return page.find(text) != std::string::npos; };
    EXPECT_TRUE(says("Schema hash: " + hex(kSchemaHash))) << "write " << hex(kSchemaHash);
    EXPECT_TRUE(says("Handshake data id: " + hex(sc::fnv1a64("scribecell handshake"))))
        << "write " << hex(sc::fnv1a64("scribecell handshake"));
    EXPECT_TRUE(says("Longest message: " + std::to_string(kMessageCapacity) + " bytes"));
    EXPECT_TRUE(says("Size of the configuration: " + std::to_string(kConfigSize) + " bytes"));
    EXPECT_TRUE(says("Block grammar version: " + std::to_string(unsigned{sc::kBlockGrammarVersion})));
}

}  // namespace
