// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <toml++/toml.h>

#include "shared/geometry/vec.hpp"

/// Strict reading of TOML, for the sources of this folder only (it pulls in toml++). Every refusal is an InputError
/// with file, line, value and what to do.

namespace sc::host {

struct Limits {
    double least;
    double most;
};

/// One table of a file. A key that has been read is known; finish() refuses the others.
class TomlReader {
public:
    TomlReader(const std::filesystem::path& file, const toml::table& table, std::string name);

    [[nodiscard]] bool has(std::string_view key) const;
    [[nodiscard]] int line() const;
    [[nodiscard]] int line_of(std::string_view key) const;
    [[nodiscard]] const std::filesystem::path& file() const noexcept { return *file_; }

    [[nodiscard]] std::string text(std::string_view key);
    [[nodiscard]] std::string text_or(std::string_view key, std::string_view otherwise);
    /// One of the given words; the result is its index.
    [[nodiscard]] std::size_t choice(std::string_view key, const std::vector<std::string_view>& words);
    [[nodiscard]] double number(std::string_view key);
    [[nodiscard]] double number(std::string_view key, Limits limits);
    [[nodiscard]] double number_or(std::string_view key, double otherwise, Limits limits);
    [[nodiscard]] std::int64_t integer(std::string_view key, std::int64_t least, std::int64_t most);
    [[nodiscard]] std::int64_t integer_or(std::string_view key, std::int64_t otherwise, std::int64_t least,
                                          std::int64_t most);
    [[nodiscard]] std::vector<double> numbers(std::string_view key, std::size_t count);
    [[nodiscard]] std::vector<double> any_numbers(std::string_view key);
    [[nodiscard]] std::vector<std::string> texts(std::string_view key);
    [[nodiscard]] std::vector<std::int64_t> integers(std::string_view key);
    [[nodiscard]] std::vector<std::vector<double>> matrix(std::string_view key, std::size_t rows, std::size_t columns);
    [[nodiscard]] Vec3 vector(std::string_view key);
    /// Millimetres to metres.
    [[nodiscard]] Vec3 vector_mm(std::string_view key);
    /// A list of places, each [x, y, z] or { via = [x, y, z], to = [x, y, z] }; millimetres to metres.
    struct Stop {
        int line = 0;
        std::optional<Vec3> via;
        Vec3 to;
    };
    [[nodiscard]] std::vector<Stop> stops_mm(std::string_view key);
    /// A rotation matrix; refuses one that is not orthogonal to 1e-6, or a mirror.
    [[nodiscard]] Mat3 rotation(std::string_view key);
    /// A unit vector to 1e-6, normalised.
    [[nodiscard]] Vec3 unit_vector(std::string_view key);
    /// ISO 8601 with a zone.
    [[nodiscard]] std::string time(std::string_view key);

    [[nodiscard]] TomlReader table(std::string_view key);
    [[nodiscard]] std::optional<TomlReader> table_if(std::string_view key);
    /// The tables of [[key]]; none if it is absent.
    [[nodiscard]] std::vector<TomlReader> tables(std::string_view key);

    /// Throws for the first key that nobody asked for.
    void finish() const;
    [[noreturn]] void fail(std::string_view key, std::string_view problem, std::string value,
                           std::string_view action) const;

private:
    [[nodiscard]] const toml::node& get(std::string_view key);
    [[nodiscard]] const toml::array& array(std::string_view key);
    [[nodiscard]] std::string path_of(std::string_view key) const;
    [[nodiscard]] double as_number(std::string_view key, const toml::node& node) const;

    const std::filesystem::path* file_;
    const toml::table* table_;
    std::string name_;
    std::set<std::string, std::less<>> known_;
};

/// A parsed file; owns what its readers look at.
class TomlDocument {
public:
    /// Parses and checks `format` and `version`; an empty `format` asks for neither.
    TomlDocument(const std::filesystem::path& file, std::string_view text, std::string_view format);
    TomlDocument(const TomlDocument&) = delete;
    TomlDocument& operator=(const TomlDocument&) = delete;
    [[nodiscard]] TomlReader& root() noexcept { return *root_; }

private:
    std::filesystem::path file_;
    toml::table table_;
    std::optional<TomlReader> root_;
};

}  // namespace sc::host
