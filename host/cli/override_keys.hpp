// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

namespace sc::host::cli {

/// The override after a key: + (or =) and - change it by 10 %, 0 sets 100 %; it stays within what a cell takes. Nothing
/// for any other key.
[[nodiscard]] std::optional<std::uint8_t> override_after(char key, std::uint8_t percent);

/// Keys pressed in this program's terminal, without waiting and without Enter. Reads nothing where stdin is no terminal
/// or belongs to another program's foreground. The terminal is put back as it was at the end.
class TerminalKeys {
public:
    TerminalKeys();
    ~TerminalKeys();
    TerminalKeys(const TerminalKeys&) = delete;
    TerminalKeys& operator=(const TerminalKeys&) = delete;

    [[nodiscard]] bool open() const noexcept { return before_ != nullptr; }
    [[nodiscard]] std::optional<char> next();

private:
    struct Terminal;
    std::unique_ptr<Terminal> before_;
};

}  // namespace sc::host::cli
