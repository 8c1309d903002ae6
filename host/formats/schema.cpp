// SPDX-License-Identifier: Apache-2.0
#include "host/formats/schema.hpp"

#include <array>

namespace sc::host {

namespace {

constexpr std::string_view kJobs = R"sql(
CREATE TABLE jobs (
    id      INTEGER PRIMARY KEY,
    hash    INTEGER NOT NULL,             -- of the items, 64 bits, stored signed
    name    TEXT    NOT NULL,
    items   INTEGER NOT NULL CHECK (items >= 0),
    created TEXT    NOT NULL,             -- ISO 8601, UTC
    state   TEXT    NOT NULL DEFAULT 'open' CHECK (state IN ('open', 'done', 'aborted', 'failed'))
) STRICT;
CREATE TABLE progress (
    id         INTEGER PRIMARY KEY,
    job        INTEGER NOT NULL REFERENCES jobs (id),
    time       TEXT    NOT NULL,          -- ISO 8601, UTC
    sent       INTEGER NOT NULL,
    planned    INTEGER NOT NULL,
    fired      INTEGER NOT NULL,
    path       INTEGER NOT NULL,
    pass       INTEGER NOT NULL,
    pulses     INTEGER NOT NULL,
    cell_state INTEGER NOT NULL
) STRICT;
CREATE INDEX progress_of_job ON progress (job, id);
)sql";

constexpr std::string_view kMeasurements = R"sql(
CREATE TABLE measurements (
    id          INTEGER PRIMARY KEY,
    job         INTEGER REFERENCES jobs (id),
    time        TEXT    NOT NULL,         -- ISO 8601, UTC
    kind        TEXT    NOT NULL,         -- what was measured, e.g. 'verification'
    subject     TEXT    NOT NULL,         -- on what, e.g. 'face 90 marker 3'
    quantity    TEXT    NOT NULL,         -- e.g. 'dx'
    value       REAL    NOT NULL,
    sigma       REAL,                     -- one standard deviation, same unit
    unit        TEXT    NOT NULL,
    calibration TEXT                      -- sha256 of the calibration set in use
) STRICT;
CREATE INDEX measurements_of_job ON measurements (job, id);
)sql";

/// So that a host that is started again can go on in the same session.
constexpr std::string_view kSessions = R"sql(
ALTER TABLE jobs ADD COLUMN session INTEGER;
)sql";

constexpr std::array kMigrations{kJobs, kMeasurements, kSessions};

}  // namespace

std::span<const std::string_view> schema_migrations() noexcept { return kMigrations; }

}  // namespace sc::host
