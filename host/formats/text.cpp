// SPDX-License-Identifier: Apache-2.0
#include "host/formats/text.hpp"

#include <array>
#include <charconv>
#include <cmath>

namespace sc::host {

std::string_view trimmed(std::string_view text) noexcept {
    constexpr std::string_view kBlank = " \t\r";
    const std::size_t first = text.find_first_not_of(kBlank);
    if (first == std::string_view::npos) {
        return {};
    }
    return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::string shortened(std::string_view text) {
    constexpr std::size_t kMost = 60;
    std::string out(text.substr(0, kMost));
    for (char& c : out) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x20 || byte == 0x7F) {
            c = '?';
        }
    }
    return text.size() > kMost ? out + "..." : out;
}

std::string decimal(double value) {
    std::array<char, 32> buffer{};
    const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
    const std::string out(buffer.data(), result.ptr);
    return out.find_first_of(".e") == std::string::npos ? out + ".0" : out;
}

std::string about(double value) {
    std::array<char, 32> buffer{};
    const auto result =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 4);
    return {buffer.data(), result.ptr};
}

std::string fixed(double value, int decimals) {
    const double grid = std::pow(10.0, decimals);
    const double rounded = std::round(value * grid) == 0.0 ? 0.0 : value;
    std::array<char, 352> buffer{};  // the widest double has 309 digits before its point
    const auto result =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), rounded, std::chars_format::fixed, decimals);
    return {buffer.data(), result.ptr};
}

}  // namespace sc::host
