// SPDX-License-Identifier: Apache-2.0
#include "host/cli/asked.hpp"

#include <cmath>
#include <optional>

#include <toml++/toml.h>

#include "host/formats/error.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, int line, const std::string& problem,
                         const std::string& value) {
    throw InputError({.file = file.string(),
                      .line = line,
                      .problem = problem,
                      .value = value,
                      .action = "write a figure as name = {asked = 5.0, better = \"lower\"}"});
}

Asked figure(const std::filesystem::path& file, const std::string& name, const toml::node& node) {
    const int line = static_cast<int>(node.source().begin.line);
    const toml::table* table = node.as_table();
    if (table == nullptr) {
        refuse(file, line, "a figure is no table", name);
    }
    const std::optional<double> value = (*table)["asked"].value<double>();
    const std::optional<std::string> better = (*table)["better"].value<std::string>();
    if (!value || !std::isfinite(*value) || !better || (*better != "lower" && *better != "higher")) {
        refuse(file, line, "a figure lacks its asked value, or which side is better", name);
    }
    return {*value, *better == "lower"};
}

}  // namespace

bool meets(double value, const Asked& asked) noexcept {
    return asked.lower_is_better ? value <= asked.value : value >= asked.value;
}

std::map<std::string, Asked> read_asked(const std::filesystem::path& file, const std::string& bench) {
    const std::string text = read_text_file(file);
    toml::table root;
    try {
        root = toml::parse(text);
    } catch (const toml::parse_error& error) {
        refuse(file, static_cast<int>(error.source().begin.line), std::string(error.description()), "");
    }
    const toml::table* table = root[bench].as_table();
    if (table == nullptr) {
        refuse(file, 0, "nothing is asked of this benchmark", bench);
    }
    std::map<std::string, Asked> asked;
    for (const auto& [key, node] : *table) {
        asked[std::string(key.str())] = figure(file, std::string(key.str()), node);
    }
    return asked;
}

}  // namespace sc::host::cli
