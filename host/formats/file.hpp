// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace sc::host {

/// Largest text file that is read: a job, a table or a calibration is far smaller, a wrong path may be anything.
inline constexpr std::size_t kTextFileLimit = 64U << 20U;

/// The bytes of a file. Throws InputError if it is missing, a folder, unreadable or larger than kTextFileLimit.
[[nodiscard]] std::string read_text_file(const std::filesystem::path& path);

/// Writes all or nothing: a file beside it is written, synced and renamed over `path`. Throws InputError if the folder
/// is missing or cannot be written; the old file, if any, is then untouched.
void write_text_file(const std::filesystem::path& path, std::string_view text);

/// A folder, with those above it; one that is there is fine. Throws InputError.
void make_folder(const std::filesystem::path& path);

/// `path` as it stands in `file`: relative paths are relative to the folder of `file`.
[[nodiscard]] std::filesystem::path beside(const std::filesystem::path& file, const std::filesystem::path& path);

/// The inverse of `beside`: the text to store in `file` for `path`; relative where both are relative or both absolute.
[[nodiscard]] std::string stored_path(const std::filesystem::path& file, const std::filesystem::path& path);

}  // namespace sc::host
