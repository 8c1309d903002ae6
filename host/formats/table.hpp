// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "shared/geometry/frames.hpp"
#include "shared/machine/machine.hpp"

namespace sc::host {

/// One marker of a verification table: where the chain of calibrations says it is and where it truly is, both in h with
/// the turntable at that face.
struct TableRow {
    int line = 0;           ///< in the source file
    double face_deg = 0.0;  ///< face k stands before the laser at C = −k degrees
    int no = 0;             ///< marker number within the face
    Point<frame::H> measured;
    Point<frame::H> truth;
};

struct VerificationTable {
    std::filesystem::path file;
    std::vector<TableRow> rows;  ///< in the order of the file
};

/// Reads a CSV with the columns face_deg,no,mx,my,mz,tx,ty,tz (millimetres, degrees); dx,dy,dz may be there and are not
/// used. Throws InputError for all that CsvTable refuses, an unknown column, a marker that appears twice on a face, a
/// table without rows, and numbers that look like inches or metres for a machine of this travel (unit_guess.hpp).
[[nodiscard]] VerificationTable read_table(const std::filesystem::path& path,
                                           const MachineConfig& machine = reference_machine());

/// The same with what else it prints.
struct PrintedTable {
    VerificationTable table;
    std::vector<Vec3> deviations;  ///< dx,dy,dz as they stand there, metres; empty if the file has none
    double digit = 1e-6;           ///< metres: the last decimal of the measured and true values
};
/// Throws as read_table does, and for dx,dy,dz that are not all there or no numbers.
[[nodiscard]] PrintedTable read_printed_table(const std::filesystem::path& path,
                                              const MachineConfig& machine = reference_machine());

/// Writes the columns face_deg,no,mx,my,mz,tx,ty,tz,dx,dy,dz with 0.1 µm. Throws InputError if it cannot be written.
void write_table(const std::filesystem::path& path, const VerificationTable& table);

}  // namespace sc::host
