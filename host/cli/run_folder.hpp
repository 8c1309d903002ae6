// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

namespace sc::host::cli {

/// Where the files of one run go: the folder that the person named, or one for the time of the run.
class RunFolder {
public:
    /// A named folder is made when it is not there. Throws InputError if it cannot be made.
    explicit RunFolder(const std::optional<std::filesystem::path>& named);
    RunFolder(const RunFolder&) = delete;
    RunFolder& operator=(const RunFolder&) = delete;
    /// Removes a folder that was not named.
    ~RunFolder();

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
    [[nodiscard]] bool named() const noexcept { return named_; }

private:
    std::filesystem::path path_;
    bool named_;
};

}  // namespace sc::host::cli
