// SPDX-License-Identifier: Apache-2.0
#include "host/formats/calibration_records.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "host/formats/calibration_units.hpp"
#include "host/formats/iso_time.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr Limits kDays{1e-3, 36'500.0};

RecordSummary summary(const std::string& id, const Provenance& provenance) {
    return {.id = id,
            .time = provenance.time,
            .validity = provenance.validity,
            .parents = provenance.parents,
            .residual_rms = provenance.residual_rms,
            .note = provenance.note};
}

template <class Record>
void add(std::vector<RecordSummary>& out, const std::string& id, const std::optional<Record>& record) {
    if (record) {
        out.push_back(summary(id, record->provenance));
    }
}

template <class Record>
void add_plain(std::vector<RecordSummary>& out, const std::string& id, const std::optional<Record>& record) {
    if (record) {
        out.push_back({.id = id,
                       .time = record->time,
                       .validity = record->validity,
                       .parents = {},
                       .residual_rms = std::nullopt,
                       .note = record->note});
    }
}

template <std::size_t N>
CovarianceBlock block(const std::string& id, std::string_view order, const Lengths<N>& lengths,
                      const Covariance<N>& covariance) {
    CovarianceBlock out{.id = id, .order = order, .lengths = {lengths.begin(), lengths.end()}, .at = {}};
    for (const auto& row : covariance.at) {
        out.at.emplace_back(row.begin(), row.end());
    }
    return out;
}

/// Where each block begins in the whole.
std::vector<std::size_t> starts_of(const std::vector<CovarianceBlock>& blocks) {
    std::vector<std::size_t> out;
    std::size_t at = 0;
    for (const CovarianceBlock& b : blocks) {
        out.push_back(at);
        at += b.at.size();
    }
    return out;
}

const CovarianceBlock& named_block(const TomlReader& table, const std::vector<CovarianceBlock>& blocks,
                                   const std::string& id) {
    const auto found = std::ranges::find(blocks, id, &CovarianceBlock::id);
    if (found == blocks.end()) {
        std::vector<std::string> known;
        for (const CovarianceBlock& b : blocks) {
            known.push_back(b.id);
        }
        table.fail("between", "names a record without a covariance", shortened(id),
                   "choose of: " + joined(known, ", "));
    }
    return *found;
}

void check_order(TomlReader& table, std::string_view key, const CovarianceBlock& b) {
    if (const std::string found = table.text(key); found != b.order) {
        table.fail(key, "is not the order of " + b.id, shortened(found), "reorder to " + std::string(b.order));
    }
}

}  // namespace

std::vector<RecordSummary> record_summaries(const CalibrationSet& set) {
    std::vector<RecordSummary> out;
    for (const TransformRecord& record : set.transforms) {
        out.push_back(summary(record.id, record.provenance));
    }
    add(out, "turntable", set.turntable);
    add(out, "axes", set.axes);
    add(out, "axis_map", set.axis_map);
    add(out, "galvo", set.galvo);
    add(out, "galvo_field", set.galvo_field);
    add(out, "galvo_lag", set.galvo_lag);
    add_plain(out, "power", set.power);
    add_plain(out, "beam", set.beam);
    add(out, "y_sensor", set.y_sensor);
    for (std::size_t i = 0; i < set.triple_head.size(); ++i) {
        out.push_back(summary("triple_head " + std::to_string(i + 1), set.triple_head[i].provenance));
    }
    add(out, "triple", set.triple);
    return out;
}

std::optional<std::chrono::sys_seconds> expiry_of(const std::string& time, const Validity& validity) {
    if (!validity.expires.empty()) {
        return parse_iso_time(validity.expires);
    }
    const auto made = parse_iso_time(time);
    if (!(validity.days > 0.0) || !made) {
        return std::nullopt;
    }
    return *made + std::chrono::seconds(std::llround(validity.days * 86'400.0));
}

std::vector<ExpiredRecord> expired_records(const CalibrationSet& set, std::chrono::sys_seconds now) {
    std::vector<ExpiredRecord> out;
    for (const RecordSummary& record : record_summaries(set)) {
        if (const auto end = expiry_of(record.time, record.validity); end && *end <= now) {
            out.push_back({record.id, *end});
        }
    }
    return out;
}

std::vector<CovarianceBlock> covariance_blocks(const CalibrationSet& set) {
    std::vector<CovarianceBlock> out;
    for (const TransformRecord& record : set.transforms) {
        out.push_back(block(record.id, kRigidOrder, kRigidLengths, record.covariance));
    }
    if (set.turntable) {
        out.push_back(block("turntable", kAxisOrder, kAxisLengths, set.turntable->covariance));
    }
    if (set.axes) {
        out.push_back(block("axes", kAxesOrder, kAxesLengths, set.axes->covariance));
    }
    if (set.galvo) {
        out.push_back(block("galvo", kGalvoOrder, kGalvoLengths, set.galvo->covariance));
    }
    if (set.galvo_field) {
        out.push_back(block("galvo_field", kGalvoFieldOrder, kGalvoFieldLengths, set.galvo_field->covariance));
    }
    if (set.galvo_lag) {
        out.push_back(block("galvo_lag", kGalvoLagOrder, kGalvoLagLengths, set.galvo_lag->covariance));
    }
    return out;
}

std::vector<std::vector<double>> joint_covariance(const CalibrationSet& set,
                                                  const std::vector<CovarianceBlock>& blocks) {
    const std::vector<std::size_t> start = starts_of(blocks);
    const std::size_t size = blocks.empty() ? 0 : start.back() + blocks.back().at.size();
    std::vector<std::vector<double>> out(size, std::vector<double>(size, 0.0));
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        for (std::size_t i = 0; i < blocks[b].at.size(); ++i) {
            std::ranges::copy(blocks[b].at[i], out[start[b] + i].begin() + static_cast<std::ptrdiff_t>(start[b]));
        }
    }
    const auto start_of = [&](const std::string& id) -> std::optional<std::size_t> {
        const auto found = std::ranges::find(blocks, id, &CovarianceBlock::id);
        if (found == blocks.end()) {
            return std::nullopt;
        }
        return start[static_cast<std::size_t>(found - blocks.begin())];
    };
    for (const CrossCovariance& cross : set.cross) {
        const auto row = start_of(cross.between[0]);
        const auto column = start_of(cross.between[1]);
        for (std::size_t i = 0; row && column && i < cross.at.size(); ++i) {
            for (std::size_t j = 0; j < cross.at[i].size(); ++j) {
                out[*row + i][*column + j] = cross.at[i][j];
                out[*column + j][*row + i] = cross.at[i][j];
            }
        }
    }
    return out;
}

Validity read_validity(TomlReader& table, const std::string& time) {
    Validity out;
    if (table.has("valid_days")) {
        out.days = table.number("valid_days", kDays);
    }
    if (table.has("expires")) {
        out.expires = table.time("expires");
        if (out.days > 0.0) {
            table.fail("expires", "stands beside valid_days", shortened(out.expires), "give one of the two");
        }
        if (!(*parse_iso_time(out.expires) > *parse_iso_time(time))) {
            table.fail("expires", "is not after the record's own time", shortened(out.expires),
                       "give a time after " + time);
        }
    }
    return out;
}

void write_validity(TomlWriter& out, const Validity& validity) {
    if (validity.days > 0.0) {
        out.number("valid_days", validity.days);
    }
    out.text_unless_empty("expires", validity.expires);
}

void read_cross_covariances(TomlReader& root, CalibrationSet& set) {
    const std::vector<CovarianceBlock> blocks = covariance_blocks(set);
    std::set<std::pair<std::string, std::string>> seen;
    for (TomlReader& table : root.tables("cross_covariance")) {
        const std::vector<std::string> ids = table.texts("between");
        if (ids.size() != 2 || ids[0] == ids[1]) {
            table.fail("between", "does not name two records", shortened(joined(ids, ", ")),
                       "give two ids that differ");
        }
        const CovarianceBlock& a = named_block(table, blocks, ids[0]);
        const CovarianceBlock& b = named_block(table, blocks, ids[1]);
        if (!seen.insert(std::minmax(ids[0], ids[1])).second) {
            table.fail("between", "appears twice", shortened(joined(ids, ", ")), "keep one of them");
        }
        check_order(table, "rows_order", a);
        check_order(table, "columns_order", b);
        CrossCovariance cross{.between = {ids[0], ids[1]}, .at = table.matrix("covariance", a.at.size(), b.at.size())};
        for (std::size_t i = 0; i < a.at.size(); ++i) {
            for (std::size_t j = 0; j < b.at.size(); ++j) {
                cross.at[i][j] = kMillimetre.to_si(cross.at[i][j], a.lengths[i] + b.lengths[j]);
            }
        }
        table.finish();
        set.cross.push_back(std::move(cross));
    }
}

void write_cross_covariances(TomlWriter& out, const CalibrationSet& set) {
    const std::vector<CovarianceBlock> blocks = covariance_blocks(set);
    for (const CrossCovariance& cross : set.cross) {
        out.item("cross_covariance");
        out.texts("between", {cross.between[0], cross.between[1]});
        const auto a = std::ranges::find(blocks, cross.between[0], &CovarianceBlock::id);
        const auto b = std::ranges::find(blocks, cross.between[1], &CovarianceBlock::id);
        if (a == blocks.end() || b == blocks.end()) {
            continue;  // the reader, which sees every file before it is written, refuses it by name
        }
        auto rows = cross.at;
        for (std::size_t i = 0; i < rows.size() && i < a->lengths.size(); ++i) {
            for (std::size_t j = 0; j < rows[i].size() && j < b->lengths.size(); ++j) {
                rows[i][j] = file_value(rows[i][j], kMillimetre.divisor_of(a->lengths[i] + b->lengths[j]));
            }
        }
        out.text("rows_order", a->order);
        out.text("columns_order", b->order);
        out.matrix("covariance", rows);
    }
}

void check_joint_covariance(const TomlReader& root, const CalibrationSet& set) {
    if (!set.cross.empty() && !is_positive_definite(joint_covariance(set, covariance_blocks(set)))) {
        root.fail("cross_covariance", "makes the combined covariance one that cannot be", "not positive definite",
                  "give cross-covariances that an estimation made together with the records");
    }
}

}  // namespace sc::host
