// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/formats/eds.hpp"
#include "shared/drives/drive_plan.hpp"
#include "shared/machine/machine.hpp"

/// What a CiA 402 drive can do for an axis by its data sheet: the objects that the controller needs, one by one, and
/// the set-up that it would be sent (docs/drives.md has the reasons). Host only.

namespace sc::host {

/// One access of the set-up, in the order of sending.
struct DriveStep {
    enum class Kind : std::uint8_t { expect_bits, expect_value, write, write_if_there, write_and_read_back };
    Kind kind = Kind::write;
    EdsKey key;
    int size = 0;  ///< bytes
    std::uint32_t value = 0;
    bool sent = true;  ///< false: the object may be absent, and is
    bool operator==(const DriveStep&) const = default;
};

struct DriveFinding {
    enum class Kind : std::uint8_t {
        missing,   ///< an object that must be there is not: the drive cannot be used
        wrong,     ///< it is there, but cannot be used as it must
        absent,    ///< an object that may be absent is
        to_check,  ///< the file does not say; the controller reads it from the drive before it goes on
        note,
    };
    Kind kind = Kind::note;
    EdsKey key;
    int line = 0;  ///< of the file; 0: the object is not there
    std::string text;
};
[[nodiscard]] const char* name_of(DriveFinding::Kind kind) noexcept;

struct DriveReport {
    std::vector<std::string> modes;  ///< by object 6502, in CiA 402's short names; empty: the file does not say
    bool paired_targets = false;     ///< one RPDO may carry two axes' targets (dummy mapping of 0007)
    bool nth_sync = false;           ///< its status may come with every n-th SYNC
    std::vector<DriveFinding> findings;
    std::vector<DriveStep> steps;
    /// Nothing is missing or wrong.
    [[nodiscard]] bool usable() const noexcept;
};

/// For this axis of the machine (its node, cycle, speeds, counts). What the plan asks for and the drive cannot do is
/// wrong; what the plan says to be absent is not sent.
[[nodiscard]] DriveReport judge_drive(const Eds& eds, const MachineConfig& machine, std::size_t axis,
                                      const DrivePlan& plan = kPlainDrives);

/// The plan of a drive by its data sheet: what it lacks, and who made it; the rest as in `wanted`.
[[nodiscard]] DriveOptions options_by(const Eds& eds, const DriveOptions& wanted);

}  // namespace sc::host
