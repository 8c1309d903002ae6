// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

namespace sc::stm32h743::test {

struct Table {
    std::map<std::string, std::uint32_t> address;
    std::map<std::string, std::uint32_t> mask;  ///< REGISTER.FIELD
};

/// tests/data/stm32h743/`name`.csv.
inline Table read_table(const std::string& name) {
    Table table;
    std::ifstream file(SC_TEST_DATA "/stm32h743/" + name + ".csv");
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
        std::istringstream in(line);
        std::array<std::string, 5> cell;
        for (std::string& one : cell) {
            std::getline(in, one, ',');
        }
        table.address[cell[0]] = static_cast<std::uint32_t>(std::stoul(cell[1], nullptr, 16));
        if (!cell[2].empty()) {
            const std::uint64_t bits = (std::uint64_t{1} << std::stoul(cell[4])) - 1U;
            table.mask[cell[0] + "." + cell[2]] = static_cast<std::uint32_t>(bits << std::stoul(cell[3]));
        }
    }
    return table;
}

}  // namespace sc::stm32h743::test
