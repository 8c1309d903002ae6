// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/resume.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <limits>
#include <tuple>
#include <variant>

#include "host/formats/error.hpp"
#include "shared/path/job_hash.hpp"

namespace sc::host {
namespace {

/// Items of one pass of a path, begin and end included.
struct Stretch {
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    const PathBegin* path = nullptr;
};

std::optional<Stretch> find_path(std::span<const Item> items, std::uint32_t path, std::uint8_t pass) {
    std::optional<Stretch> found;
    for (std::size_t i = 0; i < items.size(); ++i) {
        const auto* begin = std::get_if<PathBegin>(&items[i]);
        if (begin != nullptr && begin->path == path && begin->pass == pass) {
            found = Stretch{static_cast<std::uint32_t>(i), 0, begin};
        } else if (found && std::holds_alternative<PathEnd>(items[i])) {
            found->end = static_cast<std::uint32_t>(i);
            return found;
        }
    }
    return std::nullopt;
}

[[noreturn]] void foreign(const FiredPlace& place) {
    throw InputError({.file = {},
                      .problem = "the place that the job is said to have come to is none of this job",
                      .value = "item " + std::to_string(place.fired) + ", path " + std::to_string(place.path),
                      .action = "burn the job anew with another journal, or report this with the journal"});
}

bool may_begin(const Item& item) {
    return std::holds_alternative<PathBegin>(item) || std::holds_alternative<Turn>(item) ||
           std::holds_alternative<JobEnd>(item) || std::holds_alternative<Look>(item);
}

std::string path_text(std::uint32_t path, std::uint8_t pass) {
    return "path " + std::to_string(path) + ", pass " + std::to_string(int{pass});
}

std::optional<FiredPlace> read_place(const std::string& word) {
    FiredPlace place;
    const char* at = word.data();
    const char* const end = at + word.size();
    unsigned pass = 0;
    const auto number = [&](auto& value, char separator) {
        const auto [next, error] = std::from_chars(at, end, value);
        const bool good =
            error == std::errc{} && next != at && (separator == 0 ? next == end : next != end && *next == separator);
        at = good && separator != 0 ? next + 1 : next;
        return good;
    };
    if (!number(place.path, '/') || !number(pass, '/') || !number(place.pulses, char{0}) ||
        pass > std::numeric_limits<std::uint8_t>::max()) {
        return std::nullopt;
    }
    place.pass = static_cast<std::uint8_t>(pass);
    return place;
}

/// No turn between, so that what is looked at before `from` is remembered at `until`.
bool same_face(std::span<const Item> items, std::uint32_t from, std::uint32_t until) {
    return std::ranges::none_of(items.subspan(from, until - from),
                                [](const Item& item) { return std::holds_alternative<Turn>(item); });
}

/// The item that comes next, and how much of it is done. After a resume behind looks a place without pulses names the
/// path that is to come, and `fired` may lie before it: those between were burnt before.
struct Next {
    std::uint32_t item = 0;
    std::uint32_t pulses = 0;
};
Next next_of(std::span<const Item> items, const FiredPlace& place) {
    const auto path = find_path(items, place.path, place.pass);
    if (path && place.pulses > 0 && place.fired <= path->end) {
        return {path->begin, place.pulses};
    }
    const bool within = path && place.fired > path->begin && place.fired <= path->end;
    const bool before = path && place.fired <= path->begin && same_face(items, place.fired, path->begin);
    if (place.pulses == 0 && (within || before)) {
        return {path->begin, 0};
    }
    return {place.fired, 0};
}

/// Where to begin so that the surface is looked at again before `item`: the first look of its group.
std::uint32_t looks_of(std::span<const Item> items, std::uint32_t item) {
    const auto look = [&items](std::uint32_t i) { return std::holds_alternative<Look>(items[i]); };
    std::uint32_t at = item;
    while (at > 0 && !look(at) && !std::holds_alternative<Turn>(items[at])) {
        --at;
    }
    if (!look(at)) {
        return item;
    }
    while (at > 0 && look(at - 1)) {
        --at;
    }
    return at;
}

/// Where a place lies in the order of the job: the item that comes next, then the pulse.
std::tuple<std::uint32_t, std::uint32_t> order_of(std::span<const Item> items, const FiredPlace& place) {
    const Next next = next_of(items, place);
    return {next.item, next.pulses};
}

}  // namespace

KnownPlace known_place(const std::optional<link::Position>& told, const std::optional<JobProgress>& last,
                       std::uint64_t job, std::uint32_t items) {
    const auto source = told ? static_cast<link::PositionSource>(told->source) : link::PositionSource::none;
    if (source != link::PositionSource::none && told->job == job && told->items == items) {
        KnownPlace known;
        known.source = source == link::PositionSource::memory ? PlaceSource::controller : PlaceSource::retained;
        known.certain = {told->fired, told->path, told->pass, told->pulses};
        known.reached = {told->fired, told->reached_path, told->reached_pass, told->reached_pulses};
        return known;
    }
    KnownPlace known{.source = PlaceSource::journal, .certain = {}, .reached = {}};
    if (last && last->sent > 0) {
        known.certain = {last->fired, last->path, last->pass, last->pulses};
        known.reached = {last->sent, last->path, last->pass, std::numeric_limits<std::uint32_t>::max()};
    }
    return known;
}

ResumePoint resume_point(std::span<const Item> items, const FiredPlace& place) {
    ResumePoint point;
    const Next next = next_of(items, place);
    if (next.item >= items.size() || !may_begin(items[next.item])) {
        foreign(place);
    }
    const bool ends = std::holds_alternative<JobEnd>(items[next.item]);
    point.first = ends ? next.item : looks_of(items, next.item);
    point.pulses = next.pulses;
    for (const Item& item : items.subspan(next.item)) {
        if (const auto* begin = std::get_if<PathBegin>(&item)) {
            point.path = begin->path;
            point.pass = begin->pass;
            break;
        }
    }
    JobHasher hasher;
    for (const Item& item : items.first(point.first)) {
        hasher.add(item);
        if (const auto* turn = std::get_if<Turn>(&item)) {
            point.c = turn->c;
        }
    }
    if (const auto* turn = std::get_if<Turn>(&items[point.first])) {
        point.c = turn->c;
    }
    point.hash_before = hasher.value();
    return point;
}

std::string describe_uncertain(std::span<const Item> items, const KnownPlace& known) {
    const FiredPlace& from = known.certain;
    const FiredPlace& to = known.reached;
    const std::string start = "pulse " + std::to_string(from.pulses) + " of " + path_text(from.path, from.pass);
    if (known.source == PlaceSource::journal) {
        return "from " + start + " (item " + std::to_string(from.fired) + ") to item " + std::to_string(to.fired) +
               ", the last that was sent";
    }
    if (from.path != to.path || from.pass != to.pass) {
        return "from " + start + " to pulse " + std::to_string(to.pulses) + " of " + path_text(to.path, to.pass);
    }
    std::string text = "pulses " + std::to_string(from.pulses) + " to " + std::to_string(to.pulses - 1) + " of " +
                       path_text(from.path, from.pass);
    if (const auto path = find_path(items, from.path, from.pass)) {
        std::array<char, 32> length{};
        const double mm = static_cast<double>(to.pulses - from.pulses) * path->path->pitch_nm * 1e-6;
        std::snprintf(length.data(), length.size(), " (%.3f mm)", mm);
        text += length.data();
    }
    return text;
}

FiredPlace confirmed_place(std::span<const Item> items, const KnownPlace& known, const std::string& word) {
    if (word == "unburnt") {
        return known.certain;
    }
    if (word == "burnt" && known.source != PlaceSource::journal) {
        return known.reached;
    }
    const auto refuse = [&](const std::string& problem, const std::string& action) {
        throw InputError({.file = {}, .problem = problem, .value = word, .action = action});
    };
    const std::string form = "say unburnt, burnt, or PATH/PASS/PULSES as counted on the part";
    if (word == "burnt") {
        refuse("the journal alone cannot tell where that stretch ends",
               "say PATH/PASS/PULSES as counted on the part, or unburnt");
    }
    auto place = read_place(word);
    if (!place) {
        refuse("no answer to what is burnt", form);
    }
    const auto path = find_path(items, place->path, place->pass);
    if (!path) {
        refuse("the job has no such path and pass", form);
    }
    place->fired = path->begin;
    const bool before = order_of(items, *place) < order_of(items, known.certain);
    const bool behind = known.source == PlaceSource::journal ? path->begin >= known.reached.fired
                                                             : order_of(items, *place) > order_of(items, known.reached);
    if (before || behind) {
        refuse("this is outside the uncertain stretch, " + describe_uncertain(items, known), form);
    }
    return *place;
}

}  // namespace sc::host
