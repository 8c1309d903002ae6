// SPDX-License-Identifier: Apache-2.0
#include "host/cli/measure_link.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <random>
#include <thread>

#include <fmt/format.h>

#include "host/bridge/client.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/sensors_text.hpp"
#include "shared/codes/codes.hpp"
#include "shared/path/item.hpp"

namespace sc::host::cli {
namespace {

constexpr Nanoseconds kPoll = std::chrono::milliseconds(20);
constexpr Nanoseconds kQuiet = std::chrono::milliseconds(500);
constexpr std::size_t kFirst = 1;  ///< of the triple head among the cell's sensors

double mm(std::int32_t wire) { return static_cast<double>(wire) * 1e3 / kWireUnitsPerMetre; }

/// Before its first value a sensor is looking for it: that is no fault yet.
bool starting(std::uint16_t code) {
    return code == static_cast<std::uint16_t>(SensorCode::not_read) ||
           code == static_cast<std::uint16_t>(SensorCode::unconfirmed);
}

class CellRows {
public:
    CellRows(const std::string& url, const LinkOptions& options)
        : simulated_(is_simulated(url)),
          transport_(open_transport(url, options)),
          client_(*transport_, client_options(options, std::random_device{}())) {
        client_.set_stop_check(stop_requested);
        client_.connect();
        last_ = client_.now();
    }

    std::optional<std::string> next() {
        if (!headed_) {
            headed_ = true;
            return "station,d1_mm,d2_mm,d3_mm,age_ms,fault";
        }
        if (simulated_) {
            // Its virtual time would race by.
            std::this_thread::sleep_for(kPoll);
        }
        client_.pump_until([] { return false; }, kPoll);
        return row(client_.read_sensors()).value_or(std::string());
    }

private:
    std::optional<std::string> row(const link::SensorReport& report) {
        std::string fault;
        bool fresh = true;
        std::uint32_t age_us = 0;
        for (std::size_t i = kFirst; i < kFirst + 3; ++i) {
            if (report.code.at(i) != 0 && !starting(report.code.at(i))) {
                const bool fitted = report.code.at(i) != static_cast<std::uint16_t>(Refusal::sensor_not_fitted);
                fault += fmt::format("{}sensor {}: {}", fault.empty() ? "" : "; ", i,
                                     fitted ? trouble_text(report, i) : describe_code(report.code.at(i)));
            }
            fresh = fresh && report.code.at(i) == 0 && report.count.at(i) != seen_.at(i - kFirst);
            age_us = std::max(age_us, report.age_us.at(i));
        }
        const bool quiet = client_.now() - last_ >= kQuiet;
        if (!fresh && !quiet) {
            return std::nullopt;
        }
        last_ = client_.now();
        if (!fresh) {
            // A comma would end the column.
            std::replace(fault.begin(), fault.end(), ',', ';');
            return fmt::format("cell,,,,{:.3f},{}", age_us * 1e-3,
                               fault.empty() ? "no new value from all three sensors" : fault);
        }
        std::copy_n(report.count.begin() + kFirst, 3, seen_.begin());
        return fmt::format("cell,{:.4f},{:.4f},{:.4f},{:.3f},", mm(report.value.at(kFirst)),
                           mm(report.value.at(kFirst + 1)), mm(report.value.at(kFirst + 2)), age_us * 1e-3);
    }

    bool simulated_;
    std::unique_ptr<Transport> transport_;
    CellClient client_;
    std::array<std::uint32_t, 3> seen_{};
    HostTime last_{};
    bool headed_ = false;
};

}  // namespace

LineSource link_source(const std::string& url, const LinkOptions& options) {
    return [url, options, rows = std::shared_ptr<CellRows>()]() mutable {
        if (!rows) {
            rows = std::make_shared<CellRows>(url, options);
        }
        return rows->next();
    };
}

}  // namespace sc::host::cli
