// SPDX-License-Identifier: Apache-2.0
#include "host/formats/calibration_store.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <ranges>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "host/formats/calibration_units.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/iso_time.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

constexpr std::string_view kFormat = "scribecell-calibration-store";
constexpr std::string_view kPrefix = "store:";
constexpr std::size_t kFewestDigits = 6;
constexpr int kMostSets = 1'000'000;

/// Held while a store is read and changed.
class StoreLock {
public:
    explicit StoreLock(const std::filesystem::path& folder)
        : fd_(::open((folder / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
        if (fd_ < 0 || ::flock(fd_, LOCK_EX) != 0) {
            throw InputError({.file = folder.string(),
                              .problem = "the store cannot be written",
                              .action = "check the folder and its rights, or name another with --store"});
        }
    }
    ~StoreLock() { ::close(fd_); }
    StoreLock(const StoreLock&) = delete;
    StoreLock& operator=(const StoreLock&) = delete;

private:
    int fd_;
};

bool is_hex(std::string_view text) {
    return std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

std::optional<int> whole_number(std::string_view text) {
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

void make_folders(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder / "sets", error);
    if (error) {
        throw InputError({.file = folder.string(),
                          .problem = "the store's folder cannot be made",
                          .value = error.message(),
                          .action = "name another with --store"});
    }
}

}  // namespace

std::filesystem::path CalibrationStore::default_folder() {
    const auto variable = [](const char* name) -> std::string {
        const char* value = std::getenv(name);
        return value == nullptr ? "" : value;
    };
    if (const std::string folder = variable("SCRIBECELL_STORE"); !folder.empty()) {
        return folder;
    }
    if (const std::string data = variable("XDG_DATA_HOME"); !data.empty()) {
        return std::filesystem::path(data) / "scribecell/calibration";
    }
    if (const std::string home = variable("HOME"); !home.empty()) {
        return std::filesystem::path(home) / ".local/share/scribecell/calibration";
    }
    throw InputError({.problem = "there is no folder for the store: neither XDG_DATA_HOME nor HOME is set",
                      .action = "name one with --store, or set SCRIBECELL_STORE"});
}

CalibrationStore::CalibrationStore(std::filesystem::path folder) : folder_(std::move(folder)) { load(); }

void CalibrationStore::load() {
    sets_.clear();
    changes_.clear();
    const std::filesystem::path file = folder_ / "store.toml";
    if (!std::filesystem::exists(file)) {
        return;
    }
    TomlDocument document(file, read_text_file(file), kFormat);
    TomlReader& root = document.root();
    for (TomlReader& table : root.tables("set")) {
        StoredSet set{.no = static_cast<int>(table.integer("no", 1, kMostSets)),
                      .sha256 = table.text("sha256"),
                      .id = table.text("id"),
                      .imported = table.time("imported"),
                      .source = table.text("source")};
        if (set.sha256.size() != 64 || !is_hex(set.sha256)) {
            table.fail("sha256", "is none", shortened(set.sha256), "restore the store's list from a copy");
        }
        if (set.no != static_cast<int>(sets_.size()) + 1) {
            table.fail("no", "is out of order", std::to_string(set.no), "restore the store's list from a copy");
        }
        table.finish();
        sets_.push_back(std::move(set));
    }
    const auto most = static_cast<std::int64_t>(sets_.size());
    for (TomlReader& table : root.tables("change")) {
        changes_.push_back({.time = table.time("time"),
                            .what = table.text("what"),
                            .from = static_cast<int>(table.integer("from", 0, most)),
                            .to = static_cast<int>(table.integer("to", 1, std::max<std::int64_t>(most, 1))),
                            .note = table.text_or("note", "")});
        table.finish();
    }
    root.finish();
}

void CalibrationStore::save() const {
    TomlWriter out(kFormat);
    for (const StoredSet& set : sets_) {
        out.item("set");
        out.integer("no", set.no);
        out.text("sha256", set.sha256);
        out.text("id", set.id);
        out.text("imported", set.imported);
        out.text("source", set.source);
    }
    for (const StoreChange& change : changes_) {
        out.item("change");
        out.text("time", change.time);
        out.text("what", change.what);
        out.integer("from", change.from);
        out.integer("to", change.to);
        out.text_unless_empty("note", change.note);
    }
    write_text_file(folder_ / "store.toml", out.str());
}

const StoredSet* CalibrationStore::current() const noexcept {
    if (changes_.empty()) {
        return nullptr;
    }
    const auto at = static_cast<std::size_t>(changes_.back().to) - 1;
    return at < sets_.size() ? &sets_[at] : nullptr;
}

const StoredSet& CalibrationStore::find(std::string_view name) const {
    const auto refuse = [&](const std::string& problem, const std::string& action) {
        throw InputError({.file = folder_.string(), .problem = problem, .value = shortened(name), .action = action});
    };
    if (sets_.empty()) {
        refuse("the store has no sets", "take one in with `scribecell calibration import FILE`");
    }
    if (name.empty()) {
        if (current() == nullptr) {
            refuse("the store does not say which set is current",
                   "make one current with `scribecell calibration rollback`");
        }
        return *current();
    }
    if (const auto no = whole_number(name); no && *no >= 1 && *no <= static_cast<int>(sets_.size())) {
        return sets_[static_cast<std::size_t>(*no) - 1];
    }
    if (name.size() >= kFewestDigits && is_hex(name)) {
        const auto begins = [&name](const StoredSet& set) { return set.sha256.starts_with(name); };
        if (std::ranges::count_if(sets_, begins) > 1) {
            refuse("more than one set begins so", "give more digits");
        }
        if (const auto found = std::ranges::find_if(sets_, begins); found != sets_.end()) {
            return *found;
        }
    }
    for (const StoredSet& set : sets_ | std::views::reverse) {
        if (set.id == name) {
            return set;
        }
    }
    refuse("the store has no such set", "give a number (1 to " + std::to_string(sets_.size()) +
                                            "), a sha256 or an id: `scribecell calibration list`");
    return sets_.front();
}

std::filesystem::path CalibrationStore::file_of(const StoredSet& set) const {
    return folder_ / "sets" / (set.sha256 + ".toml");
}

const StoredSet& CalibrationStore::import(const std::filesystem::path& file, const std::string& sha256,
                                          const std::string& note) {
    const std::string text = read_text_file(file);
    const CalibrationSet set = parse_calibration(file, text);
    if (!sha256.empty() && sha256 != set.sha256) {
        throw InputError({.file = file.string(),
                          .problem = "is not the set that was asked for: its sha256 is",
                          .value = set.sha256,
                          .action = "get the file again, or correct --sha256"});
    }
    make_folders(folder_);
    const StoreLock lock(folder_);
    load();
    const int before = current() == nullptr ? 0 : current()->no;
    auto stored = std::ranges::find(sets_, set.sha256, &StoredSet::sha256);
    const std::string now = iso_time_text(now_in_seconds());
    if (stored == sets_.end()) {
        sets_.push_back({.no = static_cast<int>(sets_.size()) + 1,
                         .sha256 = set.sha256,
                         .id = set.id,
                         .imported = now,
                         .source = file.filename().string()});
        stored = sets_.end() - 1;
    }
    write_text_file(file_of(*stored), text);  // again, if it is there: a damaged file is made good
    if (stored->no != before) {
        changes_.push_back({.time = now, .what = "import", .from = before, .to = stored->no, .note = note});
        save();
    }
    return *stored;
}

const StoredSet& CalibrationStore::rollback(std::string_view name, const std::string& note) {
    static_cast<void>(find(name.empty() ? "1" : name));  // of an empty store, before anything is made
    const StoreLock lock(folder_);
    load();
    const int before = current() == nullptr ? 0 : current()->no;
    int wanted = 0;
    if (name.empty()) {
        wanted = changes_.empty() ? 0 : changes_.back().from;
        if (wanted == 0) {
            throw InputError({.file = folder_.string(),
                              .problem = "there is no earlier set",
                              .action = "name a set: `scribecell calibration list`"});
        }
    } else {
        wanted = find(name).no;
    }
    const StoredSet& target = sets_[static_cast<std::size_t>(wanted) - 1];
    const CalibrationSet set = read_calibration(file_of(target));
    if (set.sha256 != target.sha256) {
        throw InputError({.file = file_of(target).string(),
                          .problem = "the stored set was changed: its sha256 is",
                          .value = set.sha256,
                          .action = "restore the file"});
    }
    if (wanted != before) {
        changes_.push_back(
            {.time = iso_time_text(now_in_seconds()), .what = "rollback", .from = before, .to = wanted, .note = note});
        save();
    }
    return target;
}

bool names_stored_set(const std::filesystem::path& path) { return path.string().starts_with(kPrefix); }

std::filesystem::path stored_set_file(const std::filesystem::path& path) {
    const CalibrationStore store(CalibrationStore::default_folder());
    return store.file_of(store.find(path.string().substr(kPrefix.size())));
}

}  // namespace sc::host
