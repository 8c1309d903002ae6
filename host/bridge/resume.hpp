// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "host/formats/journal.hpp"
#include "shared/link/later_messages.hpp"
#include "shared/path/item.hpp"

namespace sc::host {

/// How far a job has come: every item below `fired` is done, and so many pulses of a pass of a path.
struct FiredPlace {
    std::uint32_t fired = 0;
    std::uint32_t path = 0;
    std::uint8_t pass = 0;
    std::uint32_t pulses = 0;
    bool operator==(const FiredPlace&) const noexcept = default;
};

/// Who says how far a job came.
enum class PlaceSource : std::uint8_t {
    controller,  ///< it never lost its power
    retained,    ///< the controller's memory that keeps its content without power
    journal,     ///< only what the host had written before it sent it
};

/// What is known of a job that was broken off. What lies between the two places may have been burnt or not.
struct KnownPlace {
    PlaceSource source = PlaceSource::controller;
    FiredPlace certain;
    FiredPlace reached;  ///< of the journal: `fired` alone counts, the items that were sent
    [[nodiscard]] bool exact() const noexcept { return certain == reached; }
};

/// From the controller's word, if it is about this job; else from the journal, if that tells of anything sent; else
/// the job's beginning.
[[nodiscard]] KnownPlace known_place(const std::optional<link::Position>& told, const std::optional<JobProgress>& last,
                                     std::uint64_t job, std::uint32_t items);

/// Where a job goes on. `first` 0: from its beginning. Where the Y sensor watches the surface, `first` is the first
/// look of the path's group, and the controller passes over what of the group is done.
struct ResumePoint {
    std::uint32_t first = 0;
    std::uint64_t hash_before = 0;
    std::int32_t c = 0;      ///< wire units
    std::uint32_t path = 0;  ///< the first to be burnt, and its pass
    std::uint8_t pass = 0;
    std::uint32_t pulses = 0;  ///< of that path, done
};

/// Throws InputError when the place is none of this job's.
[[nodiscard]] ResumePoint resume_point(std::span<const Item> items, const FiredPlace& place);

/// "pulses 812 to 816 of path 3, pass 0 (0.08 mm)": the stretch between the two places, for a person.
[[nodiscard]] std::string describe_uncertain(std::span<const Item> items, const KnownPlace& known);

/// What a person has found on the part: "burnt" or "unburnt", said of the whole stretch, or PATH/PASS/PULSES as
/// counted. Throws InputError for anything else, and for a place outside the stretch.
[[nodiscard]] FiredPlace confirmed_place(std::span<const Item> items, const KnownPlace& known, const std::string& word);

}  // namespace sc::host
