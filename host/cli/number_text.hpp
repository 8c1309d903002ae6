// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace sc::host::cli {

/// Six significant digits, no trailing zeros: 90, 0.25, -12.3457.
[[nodiscard]] inline std::string number_text(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6g", value);
    return text.data();
}

}  // namespace sc::host::cli
