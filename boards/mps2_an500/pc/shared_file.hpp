// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "boards/mps2_an500/shared_ram.hpp"

namespace sc::mps2_an500 {

/// The board's PSRAM on the PC: memory without a name in any folder, so that nothing is left whatever ends first.
class SharedFile {
public:
    /// Throws std::system_error.
    SharedFile();
    SharedFile(const SharedFile&) = delete;
    SharedFile& operator=(const SharedFile&) = delete;
    ~SharedFile();

    /// Valid as long as this object, all zero at first.
    [[nodiscard]] SharedRam& ram() const noexcept { return *ram_; }
    /// What a child process opens it by.
    [[nodiscard]] std::string path() const;

private:
    int file_ = -1;
    SharedRam* ram_ = nullptr;
};

}  // namespace sc::mps2_an500
