// SPDX-License-Identifier: Apache-2.0
#include "host/formats/eds.hpp"

#include <algorithm>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "host/formats/error.hpp"

namespace sc::host {
namespace {

std::filesystem::path data(const char* name) { return std::filesystem::path(SC_TEST_DATA) / "canopen" / name; }

constexpr const char* kSmall = R"([FileInfo]
FileName=small.eds
; a comment
[DeviceInfo]
VendorName=Somebody
BaudRate_500=1
BaudRate_1000=0x1
[DummyUsage]
Dummy0007=1
[MandatoryObjects]
SupportedObjects=1
1=0x1000
[1000]
ParameterName=Device Type
ObjectType=0x7
DataType=7
AccessType=ro
DefaultValue=0x00020192
[1a00]
ObjectType=0x9
SubNumber=2
[1A00sub0]
DataType=0x0005
AccessType=rw
DefaultValue=02
[1a00Sub1]
DataType=0x7
AccessType=rw
DefaultValue=$NODEID + 0xC0000500
LowLimit=0x10
HighLimit=0xFFFFFFFF
PDOMapping=1
[1003]
ObjectType=8
CompactSubObj=5
DataType=7
AccessType=ro
[60c2]
DataType=0x0002
AccessType=rw
DefaultValue=0xFD
)";

TEST(Eds, ReadsNumbersOfAllKinds) {
    const Eds eds = parse_eds("small.eds", kSmall);
    EXPECT_EQ(eds.vendor, "Somebody");
    EXPECT_EQ(eds.baud_rates, (std::vector<std::uint32_t>{500'000, 1'000'000}));
    EXPECT_TRUE(eds.dummy[7]);
    EXPECT_FALSE(eds.dummy[5]);
    ASSERT_NE(eds.find(0x1000), nullptr);
    EXPECT_EQ(eds.find(0x1000)->standard, (EdsNumber{false, 0x20192}));
    EXPECT_FALSE(eds.find(0x1000)->writable());
    EXPECT_EQ(eds.find(0x1000)->line, 13);
    ASSERT_NE(eds.find(0x1A00, 1), nullptr);
    EXPECT_EQ(eds.find(0x1A00, 1)->standard, (EdsNumber{true, 0xC0000500}));
    EXPECT_EQ(eds.find(0x1A00, 1)->standard->at(5), 0xC0000505);
    EXPECT_EQ(eds.find(0x1A00, 1)->least, (EdsNumber{false, 16}));
    EXPECT_TRUE(eds.find(0x1A00, 1)->may_be_mapped);
    EXPECT_EQ(eds.find(0x1A00, 0)->standard, (EdsNumber{false, 2})) << "octal";
    EXPECT_EQ(eds.find(0x1A00, 2), nullptr);
    ASSERT_NE(eds.find(0x1003, 5), nullptr) << "a compact array";
    EXPECT_EQ(eds.find(0x1003, 5)->size(), 4);
    EXPECT_EQ(eds.find(0x1003, 6), nullptr);
    EXPECT_EQ(eds.find(0x60C2)->standard, (EdsNumber{false, -3})) << "a signed byte";
    ASSERT_EQ(eds.notes.size(), 3U) << "1003, 1A00 and 60C2 are in no list";
}

TEST(Eds, ReadsTheDataSheetsThatThereAre) {
    const Eds servo = read_eds(data("TMCM-1636-CANopen_Hw1.1_Fw1.12.eds"));
    EXPECT_FALSE(servo.find(0x6502)->standard);
    EXPECT_EQ(servo.find(0x1016, 0)->size(), 1) << "data type written 5, without 0x";
    EXPECT_EQ(servo.find(0x1400, 1)->standard, (EdsNumber{true, 0x40000200}));
    const Eds stepper = read_eds(data("TMCM_1276_V3.22.eds"));
    EXPECT_EQ(stepper.find(0x6502)->standard, (EdsNumber{false, 0xA5}));
    EXPECT_EQ(stepper.find(0x60C2, 2)->standard, (EdsNumber{false, -3})) << "written 0xFD";
    EXPECT_FALSE(stepper.find(0x1400, 2)->writable());
    const Eds fake = read_eds(data("cia402_slave.eds"));
    EXPECT_EQ(fake.find(0x60C2, 2)->standard, (EdsNumber{false, -2}));
    EXPECT_EQ(fake.find(0x607A)->name, "Target Position 1") << "without the carriage return";
    const Eds full = read_eds(data("e35.eds"));
    EXPECT_TRUE(full.dummy[7]);
    EXPECT_EQ(full.find(0x6060)->least, (EdsNumber{false, -2}));
    EXPECT_GT(full.objects.size(), 900U);
    const auto noted = [&full](const std::string& what) {
        return std::ranges::any_of(full.notes,
                                   [&what](const EdsNote& note) { return note.text.find(what) != std::string::npos; });
    };
    EXPECT_TRUE(noted("6505 is listed, but has no section"));
    EXPECT_TRUE(noted("2FFF has a section, but is in no list"));
    EXPECT_TRUE(noted("says that it has 105 objects, and names 104"));
}

/// What a change of the small file is refused for: the line, and a word of the message.
void refused(const std::string& from, const std::string& to, int line, const std::string& word) {
    std::string text = kSmall;
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    try {
        (void)parse_eds("bad.eds", text);
        ADD_FAILURE() << "taken: " << to;
    } catch (const InputError& error) {
        EXPECT_EQ(error.file(), "bad.eds");
        EXPECT_EQ(error.line(), line) << error.what();
        EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
}

TEST(Eds, RefusesWhatIsBrokenWithItsLine) {
    refused("[1a00]", "[1a00", 19, "has no end");
    refused("ParameterName=Device Type", "ParameterName Device Type", 14, "neither a section");
    refused("DataType=7", "DataType=seven", 16, "no number");
    refused("DataType=7", "DataType=0x12345", 16, "no such data type");
    refused("DefaultValue=0x00020192", "DefaultValue=0x00020192x", 18, "no number");
    refused("DefaultValue=$NODEID + 0xC0000500", "DefaultValue=$NODEID*2", 29, "no number");
    refused("AccessType=ro", "AccessType=sometimes", 17, "no such access");
    refused("AccessType=ro", "DataType=8", 17, "twice");
    refused("[1003]", "[1000]", 33, "twice");
    refused("1=0x1000", "1=0x10000", 12, "cannot be");
    refused("[1003]", "[1004sub1]", 33, "not there");
    refused("[FileInfo]", "x=1", 1, "before the first section");
    refused("CompactSubObj=5", "CompactSubObj=255", 33, "254");
    EXPECT_THROW((void)parse_eds("empty.eds", ""), InputError);
    EXPECT_THROW((void)parse_eds("none.eds", "[FileInfo]\nFileName=x\n"), InputError);
    EXPECT_THROW((void)read_eds(data("no-such.eds")), InputError);
}

}  // namespace
}  // namespace sc::host
