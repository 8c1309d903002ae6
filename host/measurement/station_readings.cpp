// SPDX-License-Identifier: Apache-2.0
#include "host/measurement/station_readings.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr double kStuckChance = 1e-6;

struct Group {
    HeadPose pose;
    std::array<std::vector<double>, 3> values;
};

std::string number(std::size_t value) { return std::to_string(value); }

std::unexpected<StationRefusal> refuse(StationProblem problem, std::string text) {
    return std::unexpected(StationRefusal{problem, std::move(text)});
}

/// Ids of the file against those of the calibration.
std::optional<StationRefusal> other_sensors(const TripleRecord& head, const Station& station) {
    if (station.sensors[0].empty()) {
        return std::nullopt;
    }
    std::array<std::string, 3> known;
    for (std::size_t i = 0; i < 3; ++i) {
        known[i] = head.rays[i].id;
    }
    if (known == station.sensors) {
        return std::nullopt;
    }
    const std::string both = joined(station.sensors, " ") + ", the calibration has " + joined(known, " ");
    std::array<std::string, 3> a = known;
    std::array<std::string, 3> b = station.sensors;
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    if (a == b) {
        return StationRefusal{StationProblem::swapped_sensors,
                              "the sensors are exchanged: the readings are of " + both + "; put the cables right"};
    }
    return StationRefusal{StationProblem::wrong_sensors,
                          "the sensors are not those that were calibrated: the readings are of " + both +
                              "; calibrate this head, or name the right calibration"};
}

std::vector<Group> grouped(const Station& station, const StationOptions& options, std::size_t& stale,
                           std::size_t& faulty) {
    std::vector<Group> groups;
    for (const HeadReading& reading : station.readings) {
        if (!reading.fault.empty()) {
            ++faulty;
            continue;
        }
        if (reading.age && *reading.age > options.oldest) {
            ++stale;
            continue;
        }
        auto found =
            std::find_if(groups.begin(), groups.end(), [&](const Group& group) { return group.pose == reading.pose; });
        if (found == groups.end()) {
            groups.push_back({reading.pose, {}});
            found = groups.end() - 1;
        }
        for (std::size_t i = 0; i < 3; ++i) {
            found->values[i].push_back(reading.value[i]);
        }
    }
    return groups;
}

/// The step in which readings are given: the smallest difference between any two.
double resolution(const std::vector<Group>& groups) {
    std::vector<double> all;
    for (const Group& group : groups) {
        for (const auto& values : group.values) {
            all.insert(all.end(), values.begin(), values.end());
        }
    }
    std::sort(all.begin(), all.end());
    double step = 1e-3;
    for (std::size_t i = 1; i < all.size(); ++i) {
        if (const double d = all[i] - all[i - 1]; d > 1e-9) {
            step = std::min(step, d);
        }
    }
    return step;
}

bool is_stuck(const std::vector<double>& values, double sigma, double step) {
    if (values.size() < 3 ||
        *std::max_element(values.begin(), values.end()) != *std::min_element(values.begin(), values.end())) {
        return false;
    }
    const double same = std::min(1.0, step / (sigma * std::sqrt(2.0 * std::numbers::pi)));
    return std::pow(same, static_cast<double>(values.size() - 1)) < kStuckChance;
}

std::optional<StationRefusal> unusable(const TripleRecord& head, const std::vector<Group>& groups) {
    const double step = resolution(groups);
    for (const Group& group : groups) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::vector<double>& values = group.values[i];
            if (is_stuck(values, head.rays[i].sigma, step)) {
                return StationRefusal{StationProblem::stuck,
                                      "sensor " + head.rays[i].id + " gave " + fixed(values.front() * 1e3, 4) + " mm " +
                                          number(values.size()) +
                                          " times without any change: it is stuck, or its value is old; switch it "
                                          "off and on, and measure again"};
            }
            for (const double value : values) {
                if (!(value >= head.range[0] && value <= head.range[1])) {
                    return StationRefusal{StationProblem::out_of_range,
                                          "sensor " + head.rays[i].id + " gave " + fixed(value * 1e3, 3) +
                                              " mm, beyond its range of " + fixed(head.range[0] * 1e3, 1) + " to " +
                                              fixed(head.range[1] * 1e3, 1) +
                                              " mm: no surface, a glossy one, or a garbled value; look, and measure "
                                              "again"};
                }
            }
        }
    }
    return std::nullopt;
}

/// Without those that lie wildly off: beyond four standard deviations of the median, by the calibration or by the
/// readings' own median deviation, whichever is more.
std::vector<double> tame(const std::vector<double>& values, double sigma) {
    constexpr double kWild = 4.0;
    constexpr double kMadToSigma = 1.4826;
    const double middle = locate(values, sigma, Estimator::median).value;
    std::vector<double> off;
    for (const double value : values) {
        off.push_back(std::abs(value - middle));
    }
    const double limit = kWild * std::max(sigma, kMadToSigma * locate(off, sigma, Estimator::median).value);
    std::vector<double> out = values;
    std::erase_if(out, [&](double value) { return std::abs(value - middle) > limit; });
    return out;
}

/// Single readings against the calibrated noise, all sensors and poses together; wild ones do not count.
void judge_noise(const TripleRecord& head, const std::vector<Group>& groups, LocatedStation& out) {
    double over = 0.0;
    double squares = 0.0;
    double freedom = 0.0;
    for (const Group& group : groups) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::vector<double> values = tame(group.values[i], head.rays[i].sigma);
            const double s = scatter(values);
            const double n = std::max(0.0, static_cast<double>(values.size()) - 1.0);
            squares += n * s * s;
            over += n * s * s / (head.rays[i].sigma * head.rays[i].sigma);
            freedom += n;
        }
    }
    out.noise = freedom > 0.0 ? std::sqrt(squares / freedom) : 0.0;
    out.noisier = beyond_chance(over, freedom);
}

}  // namespace

std::expected<LocatedStation, StationRefusal> locate_station(const TripleRecord& head, const Station& station,
                                                             const StationOptions& options) {
    if (auto refusal = other_sensors(head, station)) {
        return std::unexpected(*refusal);
    }
    std::size_t stale = 0;
    std::size_t faulty = 0;
    std::vector<Group> groups = grouped(station, options, stale, faulty);
    std::erase_if(groups, [&](const Group& group) { return group.values[0].size() < options.fewest; });
    if (groups.empty()) {
        const std::string counts = number(station.readings.size()) + " readings, " + number(stale) +
                                   " of them older than " + fixed(options.oldest * 1e3, 0) + " ms and " +
                                   number(faulty) + " with a fault; " + number(options.fewest) +
                                   " good ones are needed";
        if (faulty > 0 && faulty >= stale) {
            std::string said;
            for (const HeadReading& reading : station.readings) {
                said = reading.fault.empty() ? said : reading.fault;
            }
            return refuse(StationProblem::sensor_fault,
                          "the sensors report a fault (" + shortened(said) + "): " + counts + "; see to the sensor");
        }
        if (stale > 0) {
            return refuse(StationProblem::stale,
                          "the readings are stale: " + counts + "; see to the bus, measure again");
        }
        return refuse(StationProblem::too_few, "too few readings at one pose of the head: " + counts);
    }
    if (auto refusal = unusable(head, groups)) {
        return std::unexpected(*refusal);
    }
    LocatedStation out;
    judge_noise(head, groups, out);
    out.left_out = 3 * (stale + faulty);
    for (const Group& group : groups) {
        PoseReadings pose{.pose = group.pose, .value = {}, .sigma = {}};
        std::size_t used = group.values[0].size();
        for (std::size_t i = 0; i < 3; ++i) {
            // What is seen counts where it is worse than the calibration.
            const double sigma = head.rays[i].sigma;
            Location location = locate(group.values[i], sigma, options.estimator);
            if (out.noisier) {
                location = locate(group.values[i], std::max(sigma, out.noise), options.estimator);
            }
            pose.value[i] = location.value;
            pose.sigma[i] = location.sigma;
            out.left_out += location.left_out;
            used = std::min(used, location.used);
        }
        out.used += used;
        out.poses.push_back(pose);
    }
    return out;
}

}  // namespace sc::host
