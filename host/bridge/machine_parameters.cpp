// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/machine_parameters.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "host/formats/error.hpp"
#include "shared/link/config.hpp"

namespace sc::host {
namespace {

constexpr std::array<const char*, kAxisCount> kAxes{"x", "y", "z", "c"};

class List {
public:
    /// `unit` SI units make one unit of the name.
    template <class Access>
    void number(const std::string& name, const std::string& text, double unit, Access access) {
        out.push_back({name, text, false, [access, unit](const MachineConfig& m) { return access(m) / unit; },
                       [access, unit](MachineConfig& m, double value) { access(m) = value * unit; }});
    }
    template <class Access>
    void quantity(const std::string& name, const std::string& text, double unit, Access access) {
        out.push_back({name, text, false, [access, unit](const MachineConfig& m) { return access(m).si() / unit; },
                       [access, unit](MachineConfig& m, double value) {
                           auto& q = access(m);
                           q = std::remove_cvref_t<decltype(q)>::from_si(value * unit);
                       }});
    }
    /// Nanoseconds; `unit` of them make one unit of the name.
    template <class Access>
    void time(const std::string& name, const std::string& text, double unit, Access access) {
        out.push_back({name, text, false,
                       [access, unit](const MachineConfig& m) { return static_cast<double>(access(m)) / unit; },
                       [access, unit](MachineConfig& m, double value) {
                           access(m) = static_cast<std::int64_t>(std::llround(value * unit));
                       }});
    }
    std::vector<MachineParameter> out;
};

void add_axis(List& list, std::size_t i) {
    const std::string axis = kAxes.at(i);
    const bool turns = i == index(Axis::c);
    const std::string unit = turns ? "deg" : "mm";
    const double size = turns ? 1.0 : 1e-3;
    const auto field = [i](double AxisConfig::* member) {
        return [i, member](auto& m) -> auto& { return m.axis.at(i).*member; };
    };
    list.number(axis + ".travel_min_" + unit, "least place", size, field(&AxisConfig::travel_min));
    list.number(axis + ".travel_max_" + unit, "greatest place", size, field(&AxisConfig::travel_max));
    list.number(axis + ".speed_" + unit + "_s", "greatest speed", size, field(&AxisConfig::speed));
    list.number(axis + ".acceleration_" + unit + "_s2", "greatest acceleration", size,
                field(&AxisConfig::acceleration));
    list.number(axis + ".jerk_" + unit + "_s3", "greatest jerk", size, field(&AxisConfig::jerk));
    list.number(axis + ".following_window_" + unit, "further off its set-point is a following error", size,
                field(&AxisConfig::following_window));
    list.number(axis + ".home_" + unit, "place after homing", size, field(&AxisConfig::home_position));
    list.time(axis + ".latency_us", "from set-point to being there", 1e3,
              [i](auto& m) -> auto& { return m.axis.at(i).latency_ns; });
}

std::vector<MachineParameter> make_list() {
    List list;
    for (std::size_t i = 0; i < kAxisCount; ++i) {
        add_axis(list, i);
    }
    list.quantity("y_retracted_mm", "C turns only with y at or above this", 1e-3,
                  [](auto& m) -> auto& { return m.y_retracted; });
    list.quantity("park_tolerance_um", "axes so near to their target stand", 1e-6,
                  [](auto& m) -> auto& { return m.park_tolerance; });
    list.time("settle_ms", "standing before a galvo path", 1e6, [](auto& m) -> auto& { return m.settle_ns; });
    list.quantity("galvo.half_field_mm", "the mirrors' field, either way", 1e-3,
                  [](auto& m) -> auto& { return m.galvo.half_field; });
    list.quantity("galvo.speed_m_s", "greatest speed of a mirror at the surface", 1.0,
                  [](auto& m) -> auto& { return m.galvo.speed; });
    list.quantity("galvo.acceleration_m_s2", "greatest acceleration", 1.0,
                  [](auto& m) -> auto& { return m.galvo.acceleration; });
    list.quantity("galvo.jerk_m_s3", "greatest jerk", 1.0, [](auto& m) -> auto& { return m.galvo.jerk; });
    list.time("galvo.latency_us", "behind the frames at constant speed", 1e3,
              [](auto& m) -> auto& { return m.galvo.latency_ns; });
    list.quantity("galvo.natural_frequency_hz", "of the mirrors' servo; 0: not known", 1.0,
                  [](auto& m) -> auto& { return m.galvo.natural_frequency; });
    list.number("galvo.damping", "of the mirrors' servo", 1.0, [](auto& m) -> auto& { return m.galvo.damping; });
    list.time("laser.warning_ms", "emission warning before the master oscillator", 1e6,
              [](auto& m) -> auto& { return m.laser.warning_ns; });
    list.time("laser.mo_wait_ms", "master oscillator on before the gate", 1e6,
              [](auto& m) -> auto& { return m.laser.mo_wait_ns; });
    list.time("laser.latency_us", "from trigger to light", 1e3, [](auto& m) -> auto& { return m.laser.latency_ns; });
    list.quantity("laser.mark_speed_min_mm_s", "the gate stays shut below", 1e-3,
                  [](auto& m) -> auto& { return m.laser.mark_speed_min; });
    list.quantity("laser.guide_speed_max_mm_s", "of a preview", 1e-3,
                  [](auto& m) -> auto& { return m.laser.guide_speed_max; });
    list.time("laser.shutter_time_ms", "the shutter may take", 1e6,
              [](auto& m) -> auto& { return m.laser.shutter_time_ns; });
    list.time("heartbeat_timeout_ms", "silence of the host, unless it asks for another", 1e6,
              [](auto& m) -> auto& { return m.heartbeat_timeout_ns; });
    list.time("held_link_timeout_s", "a job waits so long for its host", 1e9,
              [](auto& m) -> auto& { return m.held_link_timeout_ns; });
    return std::move(list.out);
}

std::size_t common_prefix(std::string_view a, std::string_view b) {
    return static_cast<std::size_t>(std::ranges::mismatch(a, b).in1 - a.begin());
}

}  // namespace

const std::vector<MachineParameter>& machine_parameters() {
    static const std::vector<MachineParameter> list = make_list();
    return list;
}

const MachineParameter* find_parameter(std::string_view name) {
    const auto found = std::ranges::find(machine_parameters(), name, &MachineParameter::name);
    return found == machine_parameters().end() ? nullptr : &*found;
}

void set_parameter(MachineConfig& machine, const std::string& setting) {
    const auto refuse = [&](const std::string& problem, const std::string& action) {
        throw InputError({.file = {}, .problem = problem, .value = setting, .action = action});
    };
    const std::size_t sign = setting.find('=');
    if (sign == std::string::npos) {
        refuse("no setting", "give NAME=VALUE; `scribecell params` lists the names");
    }
    const std::string name = setting.substr(0, sign);
    const MachineParameter* const parameter = find_parameter(name);
    if (parameter == nullptr) {
        const auto nearest = std::ranges::max_element(
            machine_parameters(), {}, [&](const MachineParameter& p) { return common_prefix(p.name, name); });
        refuse("no parameter of this name", "is it " + nearest->name + "? `scribecell params` lists the names");
    }
    double value = 0.0;
    const char* const end = setting.data() + setting.size();
    const auto [rest, error] = std::from_chars(setting.data() + sign + 1, end, value);
    if (error != std::errc{} || rest != end || !std::isfinite(value) || std::abs(value) > 1e12) {
        refuse("the value is no number", "give a number in the unit that the name ends in");
    }
    MachineConfig changed = machine;
    parameter->set(changed, value);
    if (link::check(changed) != Refusal::none) {
        refuse("no controller can run with this",
               "give a value that goes with the others: a minimum below its maximum, limits "
               "and times above 0, a home within the travel");
    }
    machine = changed;
}

}  // namespace sc::host
