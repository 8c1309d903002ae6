// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/geometry/vec.hpp"

namespace sc::host {

/// The number to write for `si` where the reader divides by `divisor`: the shortest decimal that reads back to the very
/// same double, if there is one (values that came from a file have one), else the nearest.
[[nodiscard]] double file_value(double si, double divisor) noexcept;

/// Builds TOML text in the order of the calls. Numbers are written so that they read back unchanged.
class TomlWriter {
public:
    explicit TomlWriter(std::string_view format);

    void table(std::string_view name);  ///< [name]
    void item(std::string_view name);   ///< [[name]]
    void text(std::string_view key, std::string_view value);
    void text_unless_empty(std::string_view key, std::string_view value);
    void texts(std::string_view key, const std::vector<std::string>& values);
    void integer(std::string_view key, std::int64_t value);
    void integers(std::string_view key, const std::vector<int>& values);
    /// `si` in the unit of which `divisor` make one SI unit (1e3: millimetres).
    void number(std::string_view key, double si, double divisor = 1.0);
    void numbers(std::string_view key, const std::vector<double>& si, double divisor = 1.0);
    void vector(std::string_view key, const Vec3& si, double divisor = 1.0);
    /// Places and arcs, as TomlReader::stops_mm reads them.
    struct Stop {
        std::optional<Vec3> via;
        Vec3 to;
    };
    void stops(std::string_view key, const std::vector<Stop>& stops, double divisor);
    /// Already in file units.
    void matrix(std::string_view key, const std::vector<std::vector<double>>& rows);
    void rotation(std::string_view key, const Mat3& rotation);

    [[nodiscard]] const std::string& str() const noexcept { return text_; }

private:
    void line(std::string_view key, std::string_view value);
    std::string text_;
};

}  // namespace sc::host
