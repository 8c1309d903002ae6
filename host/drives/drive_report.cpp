// SPDX-License-Identifier: Apache-2.0
#include "host/drives/drive_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

namespace sc::host {
namespace {

using Kind = DriveStep::Kind;
using Found = DriveFinding::Kind;

constexpr std::uint32_t kOff = 0x8000'0000U;
constexpr std::uint32_t kNoRemoteRequest = 0x4000'0000U;
constexpr std::uint32_t kModesNeeded = 0xA0;  ///< CSP (8) and homing (6), as bits of 6502
constexpr std::int64_t kCsp = 8;
constexpr std::uint32_t kMasterNode = 127;
constexpr std::uint32_t kHomingAtSwitch = 19;
constexpr std::uint32_t kBitRate = 1'000'000;
constexpr std::uint16_t kU32Dummy = 7;
constexpr std::array<const char*, 10> kModeNames{"PP", "VL", "PV", "TQ", "", "HM", "IP", "CSP", "CSV", "CST"};

std::uint32_t clamped(double value, double least, double most) {
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(std::clamp(std::round(value), least, most)));
}
std::uint32_t counts(double value) { return clamped(value, 0.0, std::numeric_limits<std::uint32_t>::max()); }

std::string hex(std::int64_t value) {
    std::array<char, 24> text{};
    std::snprintf(text.data(), text.size(), "0x%llX", static_cast<unsigned long long>(value));
    return text.data();
}

class Judge {
public:
    Judge(const Eds& eds, const MachineConfig& machine, std::size_t axis)
        : eds_(&eds), machine_(&machine), axis_(&machine.axis.at(axis)), node_(axis_->drive_node) {}

    DriveReport run() {
        check_bus();
        check_modes();
        liveness();
        pdos();
        motion();
        homing();
        for (const EdsNote& note : eds_->notes) {
            report_.findings.push_back({Found::note, {}, note.line, note.text});
        }
        return std::move(report_);
    }

private:
    void say(Found kind, EdsKey key, const EdsObject* object, std::string text) {
        report_.findings.push_back({kind, key, object == nullptr ? 0 : object->line, std::move(text)});
    }
    /// The object, judged by what the step does with it.
    const EdsObject* step(Kind kind, EdsKey key, int size, std::uint32_t value, std::string_view why);
    void check_value(EdsKey key, const EdsObject& object, std::uint32_t value);
    void transmission(EdsKey key);
    void mapped(EdsKey key, int size, bool from_controller, std::string_view what);
    void check_bus();
    void check_modes();
    void liveness();
    void pdos();
    void one_pdo(std::uint16_t parameters, std::uint16_t mapping, std::uint32_t id, std::uint32_t first,
                 std::uint32_t second);
    void motion();
    void homing();

    const Eds* eds_;
    const MachineConfig* machine_;
    const AxisConfig* axis_;
    std::uint8_t node_;
    DriveReport report_;
};

const EdsObject* Judge::step(Kind kind, EdsKey key, int size, std::uint32_t value, std::string_view why) {
    const EdsObject* object = eds_->find(key.index, key.sub);
    const bool optional = kind == Kind::write_if_there;
    report_.steps.push_back({kind, key, size, value, object != nullptr || !optional});
    if (object == nullptr) {
        say(optional ? Found::absent : Found::missing, key, nullptr, std::string(why));
        return nullptr;
    }
    if (object->size() != size) {
        say(Found::wrong, key, object,
            "has " + std::to_string(object->size()) + " bytes (type " + hex(object->type) + "), not " +
                std::to_string(size));
    } else if (kind == Kind::expect_bits ? !object->readable() : !object->writable()) {
        say(Found::wrong, key, object,
            std::string(kind == Kind::expect_bits ? "cannot be read" : "cannot be written") + ": " + std::string(why) +
                (object->standard ? "; it is " + hex(object->standard->at(node_)) + ", and has to be " + hex(value)
                                  : std::string()));
    } else {
        check_value(key, *object, value);
    }
    return object;
}

void Judge::check_value(EdsKey key, const EdsObject& object, std::uint32_t value) {
    std::int64_t number = value;
    if (object.is_signed()) {
        const int bits = object.size() * 8;
        if (number >= (std::int64_t{1} << (bits - 1))) {
            number -= std::int64_t{1} << bits;
        }
    }
    if (object.least && number < object.least->at(node_)) {
        say(Found::wrong, key, &object,
            "takes no less than " + std::to_string(object.least->at(node_)) + ", and has to be " +
                std::to_string(number));
    }
    if (object.most && number > object.most->at(node_)) {
        say(Found::wrong, key, &object,
            "takes no more than " + std::to_string(object.most->at(node_)) + ", and has to be " +
                std::to_string(number));
    }
}

void Judge::check_bus() {
    const bool stated = !eds_->baud_rates.empty();
    if (stated && std::ranges::find(eds_->baud_rates, kBitRate) == eds_->baud_rates.end()) {
        report_.findings.push_back({Found::wrong, {}, 0, "the drive does not do 1 Mbit/s (BaudRate_1000)"});
    }
    report_.paired_targets = eds_->dummy[kU32Dummy];
}

void Judge::check_modes() {
    constexpr EdsKey kModes{0x6502, 0};
    const EdsObject* modes =
        step(Kind::expect_bits, kModes, 4, kModesNeeded, "without it nobody knows whether the drive does CSP");
    if (modes == nullptr) {
        return;
    }
    const std::int64_t bits = modes->standard ? modes->standard->value : 0;
    if (bits == 0) {
        say(Found::to_check, kModes, modes, "the file does not say which modes the drive has");
        return;
    }
    for (std::size_t i = 0; i < kModeNames.size(); ++i) {
        if (((bits >> i) & 1) != 0 && *kModeNames[i] != '\0') {
            report_.modes.emplace_back(kModeNames[i]);
        }
    }
    const std::int64_t lacking = std::int64_t{kModesNeeded} & ~bits;
    std::string has;
    for (const std::string& mode : report_.modes) {
        has += (has.empty() ? "" : ", ") + mode;
    }
    if ((lacking & (1 << (kCsp - 1))) != 0) {
        say(Found::wrong, kModes, modes,
            "the drive cannot do CSP (cyclic synchronous position): it has " + has + " (" + hex(bits) + ")");
    }
    if ((lacking & 0x20) != 0) {
        say(Found::wrong, kModes, modes, "the drive has no homing mode: it has " + has + " (" + hex(bits) + ")");
    }
}

void Judge::liveness() {
    constexpr std::uint32_t kHeartbeatMs = 20;
    const auto timeout_ms = static_cast<std::uint32_t>(machine_->heartbeat_timeout_ns / 1'000'000) & 0xFFFFU;
    step(Kind::write, {0x1017, 0}, 2, kHeartbeatMs, "the controller could not tell that the drive has fallen silent");
    step(Kind::write, {0x1016, 1}, 4, (kMasterNode << 16U) | timeout_ms,
         "nothing would stop the drive when the controller falls silent");
    step(Kind::write_if_there, {0x6007, 0}, 2, 3,
         "what the drive does on a lost connection cannot be chosen: see its manual");
}

void Judge::transmission(EdsKey key) {
    const EdsObject* object = step(Kind::write, key, 1, 1, "targets and status have to go with each SYNC");
    report_.nth_sync = report_.nth_sync || (key.index == 0x1800 && object != nullptr && object->writable());
}

void Judge::one_pdo(std::uint16_t parameters, std::uint16_t mapping, std::uint32_t id, std::uint32_t first,
                    std::uint32_t second) {
    constexpr std::string_view kWhy = "targets and status travel in this PDO";
    step(Kind::write, {parameters, 1}, 4, id | kOff, kWhy);
    transmission({parameters, 2});
    step(Kind::write, {mapping, 0}, 1, 0, kWhy);
    step(Kind::write, {mapping, 1}, 4, first, kWhy);
    step(Kind::write, {mapping, 2}, 4, second, kWhy);
    step(Kind::write, {mapping, 0}, 1, 2, kWhy);
    step(Kind::write, {parameters, 1}, 4, id, kWhy);
}

void Judge::mapped(EdsKey key, int size, bool from_controller, std::string_view what) {
    const EdsObject* object = eds_->find(key.index, key.sub);
    if (object == nullptr) {
        say(Found::missing, key, nullptr, std::string(what));
    } else if (object->size() != size) {
        say(Found::wrong, key, object,
            "has " + std::to_string(object->size()) + " bytes, not " + std::to_string(size) + ": " + std::string(what));
    } else if (!object->may_be_mapped) {
        say(Found::wrong, key, object, "cannot be mapped into a PDO: " + std::string(what));
    } else if (from_controller ? !object->writable() : !object->readable()) {
        say(Found::wrong, key, object,
            std::string(from_controller ? "cannot be written: " : "cannot be read: ") + std::string(what));
    }
}

void Judge::pdos() {
    mapped({0x6040, 0}, 2, true, "the controlword");
    mapped({0x607A, 0}, 4, true, "the target position");
    mapped({0x6041, 0}, 2, false, "the statusword");
    mapped({0x6064, 0}, 4, false, "the actual position");
    const std::uint32_t rpdo = 0x200U + node_;
    const std::uint32_t tpdo = (0x180U + node_) | kNoRemoteRequest;
    one_pdo(0x1400, 0x1600, rpdo, 0x6040'0010U, 0x607A'0020U);
    one_pdo(0x1800, 0x1A00, tpdo, 0x6041'0010U, 0x6064'0020U);
    for (std::uint16_t further = 1; further <= 3; ++further) {
        const std::uint32_t shift = further * 0x100U;
        const auto index = [further](unsigned base) { return static_cast<std::uint16_t>(base + further); };
        step(Kind::write_if_there, {index(0x1400), 1}, 4, (rpdo + shift) | kOff, "no further RPDO to be switched off");
        step(Kind::write_if_there, {index(0x1800), 1}, 4, (tpdo + shift) | kOff, "no further TPDO to be switched off");
    }
}

void Judge::motion() {
    const std::int64_t cycle_ns = machine_->control_period_ns * machine_->drive_cycle_ticks;
    const auto cycle_ms = static_cast<std::uint32_t>(cycle_ns / 1'000'000);
    step(Kind::write_if_there, {0x1006, 0}, 4, static_cast<std::uint32_t>(cycle_ns / 1000),
         "the drive finds the time between two SYNCs by itself");
    step(Kind::write_and_read_back, {0x60C2, 1}, 1, cycle_ms, "the drive has to know the time between two targets");
    step(Kind::write_and_read_back, {0x60C2, 2}, 1, 0xFD, "the drive has to know the time between two targets");
    const double lag = axis_->speed * static_cast<double>(axis_->latency_ns) * 1e-9;
    step(Kind::write_if_there, {0x6065, 0}, 4, counts((axis_->following_window + lag) * axis_->counts_per_unit),
         "only the controller watches the following error");
    step(Kind::write_if_there, {0x6066, 0}, 2, 20, "the drive's own time before a following error counts stays");
    step(Kind::write, {0x605A, 0}, 2, 2, "a quick stop has to brake, and then switch off");
    step(Kind::write_if_there, {0x6085, 0}, 4, counts(axis_->acceleration * axis_->counts_per_unit),
         "the ramp of a quick stop is the drive's own");
    step(Kind::write, {0x6060, 0}, 1, kCsp, "the mode could not be chosen");
    const EdsObject* shown = eds_->find(0x6061, 0);
    if (shown == nullptr) {
        say(Found::missing, {0x6061, 0}, nullptr, "a change of mode could not be confirmed");
    }
}

void Judge::homing() {
    constexpr double kSearch = 0.5;
    constexpr double kCreep = 0.05;
    const double speed = axis_->speed * axis_->counts_per_unit;
    step(Kind::write, {0x6098, 0}, 1, kHomingAtSwitch, "the way of homing could not be chosen");
    step(Kind::write, {0x6099, 1}, 4, counts(speed * kSearch), "the speed of homing could not be chosen");
    step(Kind::write, {0x6099, 2}, 4, counts(speed * kCreep), "the speed of homing could not be chosen");
    step(Kind::write_if_there, {0x609A, 0}, 4, counts(axis_->acceleration * axis_->counts_per_unit),
         "the acceleration of homing is the drive's own");
    step(Kind::write, {0x607C, 0}, 4,
         clamped(axis_->home_position * axis_->counts_per_unit, std::numeric_limits<std::int32_t>::min(),
                 std::numeric_limits<std::int32_t>::max()),
         "the place of the home switch could not be said");
}

}  // namespace

const char* name_of(DriveFinding::Kind kind) noexcept {
    switch (kind) {
        case Found::missing: return "missing";
        case Found::wrong: return "wrong";
        case Found::absent: return "absent";
        case Found::to_check: return "to check";
        case Found::note: break;
    }
    return "note";
}

bool DriveReport::usable() const noexcept {
    return std::ranges::none_of(
        findings, [](const DriveFinding& f) { return f.kind == Found::missing || f.kind == Found::wrong; });
}

DriveReport judge_drive(const Eds& eds, const MachineConfig& machine, std::size_t axis) {
    return Judge(eds, machine, axis).run();
}

}  // namespace sc::host
