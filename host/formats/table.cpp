// SPDX-License-Identifier: Apache-2.0
#include "host/formats/table.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"
#include "host/formats/unit_guess.hpp"

namespace sc::host {

namespace {

struct RawRow {
    TableRow row;
    Vec3 measured_mm;
    Vec3 truth_mm;
};

struct Columns {
    std::size_t face, no, mx, my, mz, tx, ty, tz;
    explicit Columns(const CsvTable& csv)
        : face(csv.column("face_deg")),
          no(csv.column("no")),
          mx(csv.column("mx")),
          my(csv.column("my")),
          mz(csv.column("mz")),
          tx(csv.column("tx")),
          ty(csv.column("ty")),
          tz(csv.column("tz")) {}
};

Vec3 metres(const Vec3& mm) { return {mm.x / 1e3, mm.y / 1e3, mm.z / 1e3}; }

std::vector<RawRow> raw_rows(const CsvTable& csv) {
    const Columns at(csv);
    std::vector<RawRow> rows;
    for (std::size_t i = 0; i < csv.size(); ++i) {
        const Vec3 m{csv.number(i, at.mx), csv.number(i, at.my), csv.number(i, at.mz)};
        const Vec3 t{csv.number(i, at.tx), csv.number(i, at.ty), csv.number(i, at.tz)};
        const TableRow row{.line = csv.line(i),
                           .face_deg = csv.number(i, at.face),
                           .no = csv.integer(i, at.no),
                           .measured = {metres(m)},
                           .truth = {metres(t)}};
        rows.push_back({row, m, t});
    }
    return rows;
}

void refuse_repeated(const std::string& file, const std::vector<RawRow>& rows) {
    std::set<std::pair<double, int>> seen;
    for (const RawRow& raw : rows) {
        if (!seen.insert({raw.row.face_deg, raw.row.no}).second) {
            throw InputError({.file = file,
                              .line = raw.row.line,
                              .problem = "marker appears twice on face " + fixed(raw.row.face_deg, 3),
                              .value = std::to_string(raw.row.no),
                              .action = "number the markers of a face without repeats"});
        }
    }
}

double largest_of(const Vec3& v) {
    double out = v.x;
    for (std::size_t i = 1; i < 3; ++i) {
        out = std::abs(v[i]) > std::abs(out) ? v[i] : out;
    }
    return out;
}

/// Measured and true values are judged apart: either may have been exported in another unit.
void refuse_other_unit(const std::string& file, const std::vector<RawRow>& rows, Vec3 RawRow::* places,
                       const MachineConfig& machine) {
    std::vector<Vec3> mm;
    int line = 0;
    double worst = 0.0;
    for (const RawRow& raw : rows) {
        const double largest = largest_of(raw.*places);
        mm.push_back(raw.*places);
        if (line == 0 || std::abs(largest) > std::abs(worst)) {
            worst = largest;
            line = raw.row.line;
        }
    }
    if (const auto unit = guess_unit_in_h(mm, machine)) {
        throw InputError({.file = file,
                          .line = line,
                          .problem = "coordinates should be millimetres and look like " + std::string(unit->name),
                          .value = decimal(worst),
                          .action = "multiply all of them by " + decimal(unit->millimetres)});
    }
}

std::string row_text(const TableRow& row) {
    const Vec3& m = row.measured.v;
    const Vec3& t = row.truth.v;
    std::string out = decimal(row.face_deg);
    if (out.ends_with(".0")) {
        out.resize(out.size() - 2);
    }
    out += "," + std::to_string(row.no);
    for (const Vec3& v : {m, t, m - t}) {
        out += "," + fixed(v.x * 1e3, 4) + "," + fixed(v.y * 1e3, 4) + "," + fixed(v.z * 1e3, 4);
    }
    return out + "\n";
}

}  // namespace

VerificationTable read_table(const std::filesystem::path& path, const MachineConfig& machine) {
    const CsvTable csv = CsvTable::read(path);
    csv.refuse_columns_beyond({"face_deg", "no", "mx", "my", "mz", "tx", "ty", "tz", "dx", "dy", "dz"});
    const std::vector<RawRow> rows = raw_rows(csv);
    if (rows.empty()) {
        throw InputError(
            {.file = path.string(), .problem = "has a header and no rows", .action = "give a row for each marker"});
    }
    refuse_repeated(path.string(), rows);
    refuse_other_unit(path.string(), rows, &RawRow::measured_mm, machine);
    refuse_other_unit(path.string(), rows, &RawRow::truth_mm, machine);
    VerificationTable table{.file = path, .rows = {}};
    for (const RawRow& raw : rows) {
        table.rows.push_back(raw.row);
    }
    return table;
}

PrintedTable read_printed_table(const std::filesystem::path& path, const MachineConfig& machine) {
    PrintedTable out{.table = read_table(path, machine), .deviations = {}, .digit = 1e-3};
    const CsvTable csv = CsvTable::read(path);
    for (std::size_t i = 0; i < csv.size(); ++i) {
        for (const std::string_view name : {"mx", "my", "mz", "tx", "ty", "tz"}) {
            const std::string& text = csv.text(i, csv.column(name));
            const std::size_t point = text.find('.');
            const std::size_t decimals = point == std::string::npos ? 0 : trimmed(text).size() - point - 1;
            out.digit =
                std::min(out.digit, std::pow(10.0, -3.0 - static_cast<double>(std::min<std::size_t>(decimals, 9))));
        }
    }
    if (csv.has("dx") || csv.has("dy") || csv.has("dz")) {
        for (std::size_t i = 0; i < csv.size(); ++i) {
            out.deviations.push_back(metres(
                {csv.number(i, csv.column("dx")), csv.number(i, csv.column("dy")), csv.number(i, csv.column("dz"))}));
        }
    }
    return out;
}

void write_table(const std::filesystem::path& path, const VerificationTable& table) {
    std::string text = "face_deg,no,mx,my,mz,tx,ty,tz,dx,dy,dz\n";
    for (const TableRow& row : table.rows) {
        text += row_text(row);
    }
    write_text_file(path, text);
}

}  // namespace sc::host
