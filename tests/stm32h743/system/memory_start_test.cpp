// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/system/memory_start.hpp"

#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "boards/stm32h743/system/memory_map.hpp"
#include "tests/stm32h743/model/core_memory.hpp"

namespace sc::stm32h743 {
namespace {

using model::Allowed;

constexpr Allowed kClosed{};
constexpr Allowed kCode{.read = true, .write = false, .execute = true, .cached = true, .written_late = false};
constexpr Allowed kData{.read = true, .write = true, .execute = false, .cached = false, .written_late = false};

struct Place {
    std::uint32_t first, last;
    Allowed allowed;
};
constexpr Place kPlaces[]{
    {0x0000'0000, 0x0000'00FF, kClosed},
    {0x0000'0100, 0x0000'FFFF, {.read = true, .write = false, .execute = true, .cached = false, .written_late = false}},
    {0x1FFF'0000, 0x1FFF'FFFF, kClosed},
    {0x2000'0000, 0x2001'FFFF, kData},
    {0x2400'0000, 0x2407'FFFF, {.read = true, .write = true, .execute = false, .cached = true, .written_late = true}},
    {0x3000'0000, 0x3004'7FFF, kData},
    {0x3800'0000, 0x3800'FFFF, kData},
    {0x3880'0000, 0x3880'0FFF, kData},
    {0x4000'0000, 0x5FFF'FFFF, kData},
    {0x6000'0000, 0x9FFF'FFFF, kClosed},
};

void expect_plan(const model::CoreMemory& core, unsigned bank) {
    std::vector<Place> places(std::begin(kPlaces), std::end(kPlaces));
    places.push_back({0x0800'0000, 0x080F'FFFF, bank == 1 ? kCode : kData});
    places.push_back({0x0810'0000, 0x0817'FFFF, bank == 2 ? kCode : kData});
    places.push_back({0x0818'0000, 0x081F'FFFF, kData});
    for (const Place& place : places) {
        for (const std::uint32_t at : {place.first, place.first + (place.last - place.first) / 2, place.last}) {
            EXPECT_EQ(core.allowed(at), place.allowed) << std::hex << at;
        }
    }
    EXPECT_TRUE(core.caches_on());
    EXPECT_TRUE(core.division_traps());
}

void expect_clocks(const model::ClockTree& tree) {
    for (const model::Field& one :
         {model::clock_fields::kSram1En, model::clock_fields::kSram2En, model::clock_fields::kSram3En}) {
        EXPECT_TRUE(tree.on(one) && tree.settled(one)) << one.name;
    }
}

TEST(MemoryStart, FromReset) {
    model::Machine machine;
    const model::ClockTree tree(machine);
    const model::CoreMemory core(machine);
    ASSERT_TRUE(start_memory(1));
    expect_plan(core, 1);
    expect_clocks(tree);
    EXPECT_EQ(machine.violations_text(), "");
}

TEST(MemoryStart, FromABootLoaderThatOpenedEverything) {
    model::Machine machine;
    const model::ClockTree tree(machine);
    model::CoreMemory core(machine);
    core.preset_by_boot_loader();
    ASSERT_TRUE(start_memory(2));
    expect_plan(core, 2);
    EXPECT_EQ(machine.violations_text(), "");
}

TEST(MemoryStart, RefusesACoreWithFewerRegions) {
    model::Machine machine;
    const model::ClockTree tree(machine);
    const model::CoreMemory core(machine, 8);
    EXPECT_FALSE(start_memory(1));
    EXPECT_FALSE(core.caches_on());
    EXPECT_EQ(machine.violations_text(), "");
}

std::string linker_script() {
    std::ifstream file(SC_SOURCE_DIR "/boards/stm32h743/stm32h743.ld");
    return {std::istreambuf_iterator<char>(file), {}};
}

/// "64K - 256" and the like.
std::uint32_t bytes_of(const std::string& text) {
    const std::regex form(R"((\d+)K(?: - (\d+))?)");
    std::smatch parts;
    if (!std::regex_match(text, parts, form)) {
        return 0;
    }
    const unsigned long less = parts[2].matched ? std::stoul(parts[2]) : 0;
    return static_cast<std::uint32_t>(std::stoul(parts[1]) * 1024 - less);
}

TEST(MemoryMap, TheLinkerScriptHasTheSameNumbers) {
    const std::string text = linker_script();
    const std::regex line(R"((\w+)\s+\(\w+\)\s*: ORIGIN = ([^,]+), LENGTH = ([^\n]+))");
    std::map<std::string, std::pair<std::string, std::uint32_t>> found;
    for (std::sregex_iterator it(text.begin(), text.end(), line), end; it != end; ++it) {
        found[(*it)[1]] = {(*it)[2], bytes_of((*it)[3])};
    }
    const auto hex = [](std::uint32_t value) {
        char word[16];
        (void)std::snprintf(word, sizeof word, "0x%08X", value);
        return std::string(word);
    };
    const auto range = [&](const MemoryRange& one) { return std::pair(hex(one.base), one.bytes); };
    using memory::kNull;
    const std::map<std::string, std::pair<std::string, std::uint32_t>> expected{
        {"itcm", {hex(kNull.end()), memory::kItcm.bytes - kNull.bytes}},
        {"flash",
         {"DEFINED(slot_b) ? " + hex(memory::kSlotB.base) + " : " + hex(memory::kSlotA.base), memory::kSlotA.bytes}},
        {"dtcm", range(memory::kDtcm)},
        {"axi", range(memory::kAxi)},
        {"sram1", range(memory::kSram1)},
        {"sram2", range(memory::kSram2)},
        {"sram3", range(memory::kSram3)},
        {"sram4", range(memory::kSram4)},
        {"backup", range(memory::kBackupFree)},
    };
    EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace sc::stm32h743
