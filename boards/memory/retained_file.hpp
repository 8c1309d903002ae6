// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "firmware/hal/retained.hpp"

namespace sc::memory {

/// The controller's battery-backed memory as a file, mapped, so that what was written last is there however the process
/// ends. Without a path it is plain memory and forgotten with the process.
class RetainedFile {
public:
    /// Creates the file and its folder when missing. Throws std::system_error.
    explicit RetainedFile(const std::filesystem::path& path);
    RetainedFile(const RetainedFile&) = delete;
    RetainedFile& operator=(const RetainedFile&) = delete;
    ~RetainedFile();

    [[nodiscard]] RetainedMemory* memory() noexcept { return memory_; }

private:
    RetainedMemory local_;
    RetainedMemory* memory_ = &local_;
};

}  // namespace sc::memory
