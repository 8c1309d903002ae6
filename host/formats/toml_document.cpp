// SPDX-License-Identifier: Apache-2.0
#include <regex>
#include <string>

#include "host/formats/error.hpp"
#include "host/formats/text.hpp"
#include "host/formats/toml_reader.hpp"

namespace sc::host {

namespace {

constexpr std::int64_t kFormatVersion = 1;

std::string_view line_in(std::string_view text, int number) {
    for (int i = 1; i < number && !text.empty(); ++i) {
        const std::size_t end = text.find('\n');
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
    return trimmed(text.substr(0, text.find('\n')));
}

toml::table parsed(const std::filesystem::path& file, std::string_view text) {
    try {
        return toml::parse(text, file.string());
    } catch (const toml::parse_error& error) {
        const int number = static_cast<int>(error.source().begin.line);
        const std::string line(line_in(text, number));
        static const std::regex decimal_comma("=\\s*[-+]?[0-9]+,[0-9]+\\s*(#.*)?$");
        const bool comma = line.size() < 1000 && std::regex_search(line, decimal_comma);
        throw InputError(
            {.file = file.string(),
             .line = number,
             .problem = comma ? "a number has a decimal comma" : "is not TOML (" + shortened(error.description()) + ")",
             .value = shortened(line),
             .action = comma ? "write numbers with a decimal point" : "correct this line"});
    }
}

}  // namespace

TomlDocument::TomlDocument(const std::filesystem::path& file, std::string_view text, std::string_view format)
    : file_(file), table_(parsed(file, text)) {
    root_.emplace(file_, table_, "");
    if (format.empty()) {
        return;
    }
    if (!root_->has("format")) {
        throw InputError({.file = file.string(),
                          .problem = "key is missing",
                          .value = "format",
                          .action = "this must be a file with format = \"" + std::string(format) + "\""});
    }
    if (const std::string found = root_->text("format"); found != format) {
        root_->fail("format", "names another kind of file", shortened(found),
                    "give a file with format = \"" + std::string(format) + "\"");
    }
    if (const std::int64_t version = root_->integer("version", 1, 1'000'000); version > kFormatVersion) {
        root_->fail("version", "is newer than this program", std::to_string(version),
                    "use a newer scribecell, or a file of version " + std::to_string(kFormatVersion));
    }
}

}  // namespace sc::host
