// SPDX-License-Identifier: Apache-2.0
#include "host/formats/iso_time.hpp"

#include <array>
#include <cstdio>
#include <regex>

namespace sc::host {

std::optional<std::chrono::sys_seconds> parse_iso_time(std::string_view text) {
    using std::chrono::hours;
    using std::chrono::minutes;
    using std::chrono::seconds;
    static const std::regex shape(
        "([0-9]{4})-([0-9]{2})-([0-9]{2})T([0-9]{2}):([0-9]{2}):([0-9]{2})(\\.[0-9]{1,9})?"
        "(Z|([-+])([0-9]{2}):([0-9]{2}))");
    std::match_results<std::string_view::const_iterator> part;
    if (text.size() > 40 || !std::regex_match(text.begin(), text.end(), part, shape)) {
        return std::nullopt;
    }
    const auto field = [&part](std::size_t i) { return part[i].matched ? std::stoi(part[i].str()) : 0; };
    const std::chrono::year_month_day day(std::chrono::year(field(1)),
                                          std::chrono::month(static_cast<unsigned>(field(2))),
                                          std::chrono::day(static_cast<unsigned>(field(3))));
    if (!day.ok() || field(4) >= 24 || field(5) >= 60 || field(6) > 60 || field(10) >= 24 || field(11) >= 60) {
        return std::nullopt;
    }
    const auto zone = hours(field(10)) + minutes(field(11));
    const auto local = std::chrono::sys_days(day) + hours(field(4)) + minutes(field(5)) + seconds(field(6));
    return part[9].str() == "-" ? local + zone : local - zone;
}

std::string iso_time_text(std::chrono::sys_seconds time) {
    const auto midnight = std::chrono::floor<std::chrono::days>(time);
    const std::chrono::year_month_day day(midnight);
    const std::chrono::hh_mm_ss clock(time - midnight);
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02dZ", static_cast<int>(day.year()),
                  static_cast<unsigned>(day.month()), static_cast<unsigned>(day.day()),
                  static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
                  static_cast<int>(clock.seconds().count()));
    return text.data();
}

std::chrono::sys_seconds now_in_seconds() {
    return std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::system_clock::now());
}

}  // namespace sc::host
