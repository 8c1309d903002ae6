// SPDX-License-Identifier: Apache-2.0
// The committed files of docs/protocol are what the program writes today.
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "host/protocol/dbc_files.hpp"
#include "host/protocol/dissector.hpp"
#include "host/protocol/protocol_table.hpp"

namespace {

using namespace sc::host;  // NOLINT(google-build-using-namespace): the subject of this file

std::string committed(const std::string& name) {
    std::ifstream file(std::string(SC_SOURCE_DIR "/docs/protocol/") + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

constexpr const char* kWriteAgain = "write them again: scribecell protocol --write docs/protocol";

TEST(ProtocolFiles, CommittedOnesAreWhatTheProgramWrites) {
    EXPECT_TRUE(committed("scribecell.dbc") == frames_dbc()) << kWriteAgain;
    EXPECT_TRUE(committed("scribecell_messages.dbc") == messages_dbc()) << kWriteAgain;
    EXPECT_TRUE(committed("scribecell.lua") == wireshark_dissector()) << kWriteAgain;
}

/// Of names in a DBC file: Vector's tools take 32 characters.
TEST(ProtocolFiles, EveryMessageStandsInEachFileAndNamesAreShortEnough) {
    const std::string dbc = messages_dbc();
    const std::string lua = wireshark_dissector();
    std::set<unsigned> ids;
    for (const ProtocolMessage& m : protocol_messages()) {
        EXPECT_TRUE(ids.insert(m.id).second) << m.name;
        EXPECT_NE(dbc.find(" " + m.name + ": " + std::to_string(m.largest_payload + 7)), std::string::npos) << m.name;
        EXPECT_NE(lua.find("name = \"" + m.name + "\""), std::string::npos) << m.name;
        EXPECT_LE(m.name.size(), 32U);
        for (const ProtocolField& f : m.fields) {
            EXPECT_LE(f.name.size(), 26U) << m.name << '.' << f.name;
            EXPECT_NE(dbc.find(" SG_ " + f.name), std::string::npos) << f.name;
        }
    }
    EXPECT_GE(ids.size(), 26U);
}

TEST(ProtocolFiles, NoMessageOfADbcHasASignalTwice) {
    for (const std::string& text : {frames_dbc(), messages_dbc()}) {
        std::istringstream lines(text);
        std::set<std::string> signals;
        std::size_t count = 0;
        for (std::string line; std::getline(lines, line);) {
            if (line.starts_with("BO_ ")) {
                signals.clear();
            } else if (line.starts_with(" SG_ ")) {
                const std::string name = line.substr(5, line.find(' ', 5) - 5);
                EXPECT_TRUE(signals.insert(name).second) << line;
                ++count;
            }
        }
        EXPECT_GT(count, 20U);
    }
}

}  // namespace
