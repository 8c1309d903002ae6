// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/formats/calibration_set.hpp"

/// A folder of calibration sets, none of which ever changes or goes away:
///
///     FOLDER/store.toml          which sets there are, which is current, and when that changed
///     FOLDER/sets/SHA256.toml    each as it was imported, byte for byte
///
/// Every change writes new files and renames store.toml into place, so that a killed program leaves the old state; one
/// program changes a store at a time (a lock on FOLDER/lock). "store:" in place of a file's name is the current set,
/// "store:3" the third, "store:4552fa" the one whose sha256 begins so.

namespace sc::host {

struct StoredSet {
    int no = 0;  ///< from 1, in the order of import
    std::string sha256;
    std::string id;
    std::string imported;  ///< ISO 8601
    std::string source;    ///< the file's name
    bool operator==(const StoredSet&) const = default;
};
/// A change of what is current.
struct StoreChange {
    std::string time;
    std::string what;  ///< "import" or "rollback"
    int from = 0;      ///< 0: there was none
    int to = 0;
    std::string note;
    bool operator==(const StoreChange&) const = default;
};

class CalibrationStore {
public:
    /// SCRIBECELL_STORE, or scribecell/calibration below XDG_DATA_HOME, or below ~/.local/share.
    [[nodiscard]] static std::filesystem::path default_folder();

    /// Reads what is there; a folder that does not exist is an empty store. Throws InputError.
    explicit CalibrationStore(std::filesystem::path folder);

    [[nodiscard]] const std::filesystem::path& folder() const noexcept { return folder_; }
    [[nodiscard]] const std::vector<StoredSet>& sets() const noexcept { return sets_; }
    [[nodiscard]] const std::vector<StoreChange>& changes() const noexcept { return changes_; }
    [[nodiscard]] const StoredSet* current() const noexcept;
    /// By number, by the beginning of its sha256 (six digits or more) or by id, newest first; "" is the current one.
    /// Throws InputError.
    [[nodiscard]] const StoredSet& find(std::string_view name) const;
    [[nodiscard]] std::filesystem::path file_of(const StoredSet& set) const;

    /// Takes a set in, checked as read_calibration does, and makes it current. A set that is there already is not
    /// stored again. `sha256`, if not empty, must be the set's. Throws InputError; the store is then as it was.
    const StoredSet& import(const std::filesystem::path& file, const std::string& sha256, const std::string& note);
    /// Makes an earlier set current: the one named, or with "" the one that was current before. Nothing is deleted.
    const StoredSet& rollback(std::string_view name, const std::string& note);

private:
    void load();
    void save() const;

    std::filesystem::path folder_;
    std::vector<StoredSet> sets_;
    std::vector<StoreChange> changes_;
};

[[nodiscard]] bool names_stored_set(const std::filesystem::path& path);
/// The file behind "store:NAME" in the default store. Throws InputError.
[[nodiscard]] std::filesystem::path stored_set_file(const std::filesystem::path& path);

}  // namespace sc::host
