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
constexpr std::uint32_t kSkipped = 0x0007'0020U;
constexpr std::uint32_t kControlword = 0x6040'0010U;
constexpr std::uint32_t kTarget = 0x607A'0020U;
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

bool reads(Kind kind) { return kind == Kind::expect_bits || kind == Kind::expect_value; }

/// Of an object that may be absent.
std::uint16_t absent_bit(std::uint16_t index) {
    switch (index) {
        case 0x6007: return drive_object::k6007;
        case 0x1006: return drive_object::k1006;
        case 0x6065: return drive_object::k6065;
        case 0x6066: return drive_object::k6066;
        case 0x6085: return drive_object::k6085;
        case 0x609A: return drive_object::k609A;
        case 0x1401:
        case 0x1402:
        case 0x1403: return drive_object::kRpdos;
        case 0x1801:
        case 0x1802:
        case 0x1803: return drive_object::kTpdos;
        default: return 0;
    }
}

class Judge {
public:
    Judge(const Eds& eds, const MachineConfig& machine, std::size_t axis, const DrivePlan& plan)
        : eds_(&eds),
          machine_(&machine),
          axis_(&machine.axis.at(axis)),
          plan_(&plan),
          number_(axis),
          options_(plan.drive.at(axis)),
          node_(axis_->drive_node) {}

    DriveReport run() {
        check_bus();
        identity();
        check_modes();
        liveness();
        pdos();
        motion();
        homing();
        wanted_options();
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
    void identity();
    void wanted_options();
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
    const DrivePlan* plan_;
    std::size_t number_;
    DriveOptions options_;
    std::uint8_t node_;
    DriveReport report_;
};

const EdsObject* Judge::step(Kind kind, EdsKey key, int size, std::uint32_t value, std::string_view why) {
    const EdsObject* object = eds_->find(key.index, key.sub);
    const bool optional = kind == Kind::write_if_there;
    const bool left_out = optional && (options_.absent & absent_bit(key.index)) != 0;
    report_.steps.push_back({kind, key, size, value, (object != nullptr || !optional) && !left_out});
    if (object == nullptr) {
        say(optional ? Found::absent : Found::missing, key, nullptr, std::string(why));
        return nullptr;
    }
    if (object->size() != size) {
        say(Found::wrong, key, object,
            "has " + std::to_string(object->size()) + " bytes (type " + hex(object->type) + "), not " +
                std::to_string(size));
    } else if (reads(kind) ? !object->readable() : !object->writable()) {
        say(Found::wrong, key, object,
            std::string(reads(kind) ? "cannot be read" : "cannot be written") + ": " + std::string(why) +
                (object->standard ? "; it is " + hex(object->standard->at(node_)) + ", and has to be " + hex(value)
                                  : std::string()));
    } else if (!reads(kind)) {
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

void Judge::identity() {
    constexpr std::string_view kWhy = "the drive could not be told from another maker's";
    if (options_.vendor != 0) {
        step(Kind::expect_value, {0x1018, 1}, 4, options_.vendor, kWhy);
    }
    if (options_.product != 0) {
        step(Kind::expect_value, {0x1018, 2}, 4, options_.product, kWhy);
    }
}

/// What the plan asks for beyond the plain way.
void Judge::wanted_options() {
    if (options_.paired && !report_.paired_targets) {
        report_.findings.push_back(
            {Found::wrong,
             {},
             0,
             "targets in pairs are asked for, but the drive cannot skip its partner's half of an "
             "RPDO (Dummy0007 is not 1)"});
    }
    if (options_.status_every > 1 && !report_.nth_sync) {
        say(Found::wrong, {0x1800, 2}, eds_->find(0x1800, 2), "a status with every n-th SYNC is asked for");
    }
    if (options_.brake_apply_ms > 0) {
        constexpr std::string_view kWhy = "the brake could not be told to close";
        step(Kind::write, {0x60FE, 2}, 4, 1, kWhy);
        step(Kind::write, {0x60FE, 1}, 4, 1, kWhy);
    }
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
    const bool status = key.index == 0x1800;
    const EdsObject* object =
        step(Kind::write, key, 1, status ? options_.status_every : 1U, "targets and status have to go with each SYNC");
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
    const TargetPair pair = options_.paired ? target_pair(*plan_, number_) : TargetPair{};
    const bool second = options_.paired && pair.second == number_ && pair.first != number_;
    const std::uint32_t common = options_.paired ? 0x200U + machine_->axis.at(pair.first).drive_node : rpdo;
    const std::uint32_t tpdo = (0x180U + node_) | kNoRemoteRequest;
    one_pdo(0x1400, 0x1600, common, second ? kSkipped : (options_.paired ? kTarget : kControlword),
            options_.paired && !second ? kSkipped : kTarget);
    one_pdo(0x1800, 0x1A00, tpdo, 0x6041'0010U, 0x6064'0020U);
    if (options_.paired) {
        constexpr std::string_view kWhy = "the controlword travels by itself where targets are paired";
        const std::uint32_t words = rpdo + 0x100U;
        step(Kind::write, {0x1401, 1}, 4, words | kOff, kWhy);
        step(Kind::write, {0x1401, 2}, 1, 1, kWhy);
        step(Kind::write, {0x1601, 0}, 1, 0, kWhy);
        step(Kind::write, {0x1601, 1}, 4, kControlword, kWhy);
        step(Kind::write, {0x1601, 0}, 1, 1, kWhy);
        step(Kind::write, {0x1401, 1}, 4, words, kWhy);
    }
    for (std::uint16_t further = 1; further <= 3; ++further) {
        const std::uint32_t shift = further * 0x100U;
        const auto index = [further](unsigned base) { return static_cast<std::uint16_t>(base + further); };
        if (further > 1 || !options_.paired) {
            step(Kind::write_if_there, {index(0x1400), 1}, 4, (rpdo + shift) | kOff,
                 "no further RPDO to be switched off");
        }
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
    step(Kind::write, {0x6098, 0}, 1, static_cast<std::uint8_t>(options_.homing_method),
         "the way of homing could not be chosen");
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

DriveReport judge_drive(const Eds& eds, const MachineConfig& machine, std::size_t axis, const DrivePlan& plan) {
    return Judge(eds, machine, axis, plan).run();
}

DriveOptions options_by(const Eds& eds, const DriveOptions& wanted) {
    DriveOptions options = wanted;
    options.absent = 0;
    for (const std::uint16_t index : std::array<std::uint16_t, 6>{0x6007, 0x1006, 0x6065, 0x6066, 0x6085, 0x609A}) {
        const bool there = eds.find(index) != nullptr;
        options.absent = static_cast<std::uint16_t>(options.absent | (there ? 0U : absent_bit(index)));
    }
    // One bit for all of a kind: of drives that have some, the controller tries each and goes on when one is refused.
    const auto none = [&eds](std::uint16_t first) {
        return eds.find(first, 1) == nullptr && eds.find(static_cast<std::uint16_t>(first + 1), 1) == nullptr &&
               eds.find(static_cast<std::uint16_t>(first + 2), 1) == nullptr;
    };
    options.absent = static_cast<std::uint16_t>(options.absent | (none(0x1401) ? drive_object::kRpdos : 0U) |
                                                (none(0x1801) ? drive_object::kTpdos : 0U));
    const auto shown = [&eds](std::uint8_t sub, std::uint32_t number) {
        const EdsObject* const object = eds.find(0x1018, sub);
        return object != nullptr && object->readable() && object->size() == 4 ? number : 0;
    };
    options.vendor = shown(1, eds.vendor_number);
    options.product = shown(2, eds.product_number);
    return options;
}

}  // namespace sc::host
