// SPDX-License-Identifier: Apache-2.0
#include "boards/machine_file/machine_file.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <stdexcept>

#include <toml++/toml.h>

#include "shared/link/config.hpp"

namespace sc::machine_file {
namespace {

using Setter = std::function<void(MachineConfig&, double)>;
constexpr std::array<const char*, kAxisCount> kAxes{"x", "y", "z", "c"};

/// Every number that a file may give, by its path.
class Keys {
public:
    Keys() {
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            add_axis(i);
        }
        number("drive_cycle_ms", 1e6, [](MachineConfig& m, double ns) {
            m.drive_cycle_ticks =
                static_cast<std::uint32_t>(std::llround(ns / static_cast<double>(m.control_period_ns)));
        });
        number("y_retracted_mm", 1e-3, [](MachineConfig& m, double v) { m.y_retracted = Length::from_si(v); });
        number("table_y_mm", 1e-3, [](MachineConfig& m, double v) { m.table_y = Length::from_si(v); });
        number("park_tolerance_um", 1e-6, [](MachineConfig& m, double v) { m.park_tolerance = Length::from_si(v); });
        whole("settle_ms", 1e6, [](MachineConfig& m) -> auto& { return m.settle_ns; });
        whole("heartbeat_timeout_ms", 1e6, [](MachineConfig& m) -> auto& { return m.heartbeat_timeout_ns; });
        whole("held_link_timeout_s", 1e9, [](MachineConfig& m) -> auto& { return m.held_link_timeout_ns; });
        add_laser();
    }
    [[nodiscard]] const Setter* find(const std::string& path) const {
        const auto found = keys_.find(path);
        return found == keys_.end() ? nullptr : &found->second;
    }

private:
    void number(const std::string& path, double unit, Setter set) {
        keys_[path] = [unit, set = std::move(set)](MachineConfig& m, double v) { set(m, v * unit); };
    }
    template <class Access>
    void whole(const std::string& path, double unit, Access access) {
        keys_[path] = [unit, access](MachineConfig& m, double v) { access(m) = std::llround(v * unit); };
    }
    void field(const std::string& path, double unit, std::size_t axis, double AxisConfig::* member) {
        keys_[path] = [=](MachineConfig& m, double v) { m.axis.at(axis).*member = v * unit; };
    }
    void add_axis(std::size_t i) {
        const bool turns = i == index(Axis::c);
        const std::string name = std::string(kAxes.at(i)) + ".";
        const std::string unit = turns ? "deg" : "mm";
        const double size = turns ? 1.0 : 1e-3;
        field(name + "travel_min_" + unit, size, i, &AxisConfig::travel_min);
        field(name + "travel_max_" + unit, size, i, &AxisConfig::travel_max);
        field(name + "speed_" + unit + "_s", size, i, &AxisConfig::speed);
        field(name + "acceleration_" + unit + "_s2", size, i, &AxisConfig::acceleration);
        field(name + "jerk_" + unit + "_s3", size, i, &AxisConfig::jerk);
        field(name + "following_window_" + unit, size, i, &AxisConfig::following_window);
        field(name + "home_" + unit, size, i, &AxisConfig::home_position);
        field(name + "counts_per_" + unit, 1.0 / size, i, &AxisConfig::counts_per_unit);
        whole(name + "latency_us", 1e3, [i](MachineConfig& m) -> auto& { return m.axis.at(i).latency_ns; });
        keys_[name + "node"] = [i](MachineConfig& m, double v) {
            m.axis.at(i).drive_node = v >= 1.0 && v <= 127.0 ? static_cast<std::uint8_t>(v) : std::uint8_t{0};
        };
    }
    void add_laser() {
        number("laser.power_w", 1.0, [](MachineConfig& m, double v) { m.laser.power = Power::from_si(v); });
        number("laser.prr_min_khz", 1e3, [](MachineConfig& m, double v) { m.laser.prr_min = Frequency::from_si(v); });
        number("laser.prr_nominal_khz", 1e3,
               [](MachineConfig& m, double v) { m.laser.prr_nominal = Frequency::from_si(v); });
        number("laser.mark_speed_min_mm_s", 1e-3,
               [](MachineConfig& m, double v) { m.laser.mark_speed_min = Speed::from_si(v); });
        number("laser.guide_speed_max_mm_s", 1e-3,
               [](MachineConfig& m, double v) { m.laser.guide_speed_max = Speed::from_si(v); });
        whole("laser.warning_ms", 1e6, [](MachineConfig& m) -> auto& { return m.laser.warning_ns; });
        whole("laser.mo_wait_ms", 1e6, [](MachineConfig& m) -> auto& { return m.laser.mo_wait_ns; });
        whole("laser.latency_us", 1e3, [](MachineConfig& m) -> auto& { return m.laser.latency_ns; });
        whole("laser.shutter_time_ms", 1e6, [](MachineConfig& m) -> auto& { return m.laser.shutter_time_ns; });
    }
    std::map<std::string, Setter> keys_;
};

class Reader {
public:
    Reader(std::string name, MachineConfig& machine) : name_(std::move(name)), machine_(&machine) {}

    void table(const toml::table& table, const std::string& path) {
        for (const auto& [key, node] : table) {
            const std::string here = path.empty() ? std::string(key.str()) : path + "." + std::string(key.str());
            if (here == "drives") {
                continue;  // boards/drive_file
            }
            if (const toml::table* inner = node.as_table(); inner != nullptr && path.empty()) {
                this->table(*inner, here);
            } else {
                one(here, node);
            }
        }
    }

private:
    [[noreturn]] void refuse(const std::string& key, const toml::node& node, const std::string& why) const {
        throw std::invalid_argument(name_ + ":" + std::to_string(node.source().begin.line) + ": " + key + ": " + why);
    }
    [[nodiscard]] double number(const std::string& key, const toml::node& node) const {
        const std::optional<double> value = node.value<double>();
        if (!node.is_number() || !value || !std::isfinite(*value) || std::abs(*value) > 1e12) {
            refuse(key, node, "is no number that could be meant");
        }
        return *value;
    }
    void one(const std::string& key, const toml::node& node) {
        if (const Setter* set = keys_.find(key)) {
            (*set)(*machine_, number(key, node));
        } else if (key == "laser.source") {
            source(key, node);
        } else if (key == "sensors.fitted") {
            if (!node.is_boolean()) {
                refuse(key, node, "is true or false");
            }
            for (SensorConfig& sensor : machine_->sensors.sensor) {
                sensor.kind = node.ref<bool>() ? sensor.kind : SensorKind::none;
            }
        } else if (key == "keep_out_mm") {
            keep_out(key, node);
        } else {
            refuse(key, node, "is no key of a machine (boards/machine_file/README.md lists them)");
        }
    }
    void source(const std::string& key, const toml::node& node) {
        static const std::map<std::string, LaserSource> kSources{{"none", LaserSource::none},
                                                                 {"ipg", LaserSource::ipg},
                                                                 {"raycus", LaserSource::raycus},
                                                                 {"jpt", LaserSource::jpt}};
        const auto found = kSources.find(node.value_or(std::string{}));
        if (found == kSources.end()) {
            refuse(key, node, "is one of \"none\", \"ipg\", \"raycus\", \"jpt\"");
        }
        machine_->laser.source = found->second;
    }
    void keep_out(const std::string& key, const toml::node& node) {
        const toml::array* boxes = node.as_array();
        if (boxes == nullptr || boxes->size() > kKeepOutCapacity) {
            refuse(key, node, "is a list of at most " + std::to_string(kKeepOutCapacity) + " boxes");
        }
        machine_->keep_out_count = 0;
        for (const toml::node& box : *boxes) {
            const toml::array* corners = box.as_array();
            if (corners == nullptr || corners->size() != 2) {
                refuse(key, box, "a box is two corners, [[x, y, z], [x, y, z]]");
            }
            KeepOut& out = machine_->keep_out.at(machine_->keep_out_count++);
            out.min = corner(key, *corners->get(0));
            out.max = corner(key, *corners->get(1));
        }
    }
    [[nodiscard]] Vec3 corner(const std::string& key, const toml::node& node) const {
        const toml::array* place = node.as_array();
        if (place == nullptr || place->size() != 3) {
            refuse(key, node, "a corner is three numbers");
        }
        return Vec3{1e-3 * number(key, *place->get(0)), 1e-3 * number(key, *place->get(1)),
                    1e-3 * number(key, *place->get(2))};
    }

    std::string name_;
    MachineConfig* machine_;
    Keys keys_;
};

}  // namespace

MachineConfig parse_machine(std::string_view text, const std::string& name) {
    MachineConfig machine = reference_machine();
    try {
        const toml::table root = toml::parse(text, name);
        Reader(name, machine).table(root, "");
    } catch (const toml::parse_error& error) {
        throw std::invalid_argument(name + ":" + std::to_string(error.source().begin.line) + ": " +
                                    std::string(error.description()));
    }
    if (link::check(machine) != Refusal::none) {
        throw std::invalid_argument(name +
                                    ": no controller can run with this machine: a limit that is not above zero, a home "
                                    "outside the travel, a node that is not 1 to 127 or given twice, or the like");
    }
    return machine;
}

MachineConfig read_machine(const std::filesystem::path& file) {
    const std::ifstream in(file, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    if (!in) {
        throw std::invalid_argument(file.string() + ": cannot be read: " + std::strerror(errno));
    }
    return parse_machine(text.str(), file.string());
}

}  // namespace sc::machine_file
