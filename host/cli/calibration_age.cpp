// SPDX-License-Identifier: Apache-2.0
#include "host/cli/calibration_age.hpp"

#include <cstdio>

#include "host/formats/calibration_records.hpp"
#include "host/formats/error.hpp"
#include "host/formats/iso_time.hpp"
#include "host/formats/text.hpp"

namespace sc::host::cli {
namespace {

constexpr std::chrono::hours kSoon{24};

std::string list_of(const std::vector<ExpiredRecord>& records, std::chrono::sys_seconds now, const char* ago) {
    std::vector<std::string> out;
    for (const ExpiredRecord& record : records) {
        out.push_back(record.id + " (" + iso_time_text(record.since) + ", " + span_text(now - record.since) + ago +
                      ")");
    }
    return joined(out, ", ");
}

}  // namespace

std::string span_text(std::chrono::seconds span) {
    const auto seconds = span.count() < 0 ? -span.count() : span.count();
    const auto text = [](std::int64_t count, const char* unit) {
        return std::to_string(count) + " " + unit + (count == 1 ? "" : "s");
    };
    if (seconds >= 2 * 86'400) {
        return text(seconds / 86'400, "day");
    }
    if (seconds >= 2 * 3'600) {
        return text(seconds / 3'600, "hour");
    }
    return text(seconds < 60 ? 1 : seconds / 60, "minute");
}

void check_age(const CalibrationSet& set, bool accept) {
    const auto now = now_in_seconds();
    const auto expired = expired_records(set, now);
    if (!expired.empty() && !accept) {
        throw InputError({.file = set.file.string(),
                          .problem = "the calibration has expired",
                          .value = list_of(expired, now, " ago"),
                          .action = "calibrate again, or accept it as it is with --accept-expired"});
    }
    if (!expired.empty()) {
        std::fprintf(stderr, "warning: %s: the calibration has expired: %s\n", set.file.string().c_str(),
                     list_of(expired, now, " ago").c_str());
    }
    std::vector<ExpiredRecord> soon;
    for (const ExpiredRecord& record : expired_records(set, now + kSoon)) {
        if (record.since > now) {
            soon.push_back(record);
        }
    }
    if (!soon.empty()) {
        std::fprintf(stderr, "warning: %s: the calibration expires soon: %s\n", set.file.string().c_str(),
                     list_of(soon, now, " from now").c_str());
    }
}

}  // namespace sc::host::cli
