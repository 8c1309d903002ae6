// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

/// Small text helpers of this folder.

namespace sc::host {

/// Without blanks, tabs and carriage returns at both ends.
[[nodiscard]] std::string_view trimmed(std::string_view text) noexcept;
/// At most some 60 characters, printable: control bytes become '?'. For messages.
[[nodiscard]] std::string shortened(std::string_view text);
/// Shortest decimal that reads back as the same double; always with a point or an exponent, so that TOML takes it for a
/// float. `value` must be finite.
[[nodiscard]] std::string decimal(double value);
/// Four digits: for a figure that a message only illustrates.
[[nodiscard]] std::string about(double value);
/// Fixed number of decimals; −0 is written as 0.
[[nodiscard]] std::string fixed(double value, int decimals);

template <class Range>
[[nodiscard]] std::string joined(const Range& items, std::string_view separator) {
    std::string out;
    for (const auto& item : items) {
        if (!out.empty()) {
            out += separator;
        }
        out += item;
    }
    return out;
}

}  // namespace sc::host
