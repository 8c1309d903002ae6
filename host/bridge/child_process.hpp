// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "host/bridge/unique_fd.hpp"

namespace sc::host {

/// A program started by the host, with one socket between them. It runs in a process group of its own, so that Ctrl-C
/// in the terminal reaches the host alone and the host can bring the cell to rest. It is expected to end when its side
/// of the socket closes.
class ChildProcess {
public:
    /// Number of the socket in the child.
    static constexpr int kChildSocket = 3;

    /// Starts `program` (found already) with `arguments`; throws std::runtime_error when the system refuses.
    ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments);
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;
    /// Closes the socket and waits for the end, as `finish` does.
    ~ChildProcess();

    /// The host's end; −1 after `finish`.
    [[nodiscard]] int socket() const noexcept { return socket_.get(); }
    [[nodiscard]] pid_t id() const noexcept { return id_; }
    /// Closes the socket and waits up to 20 s for the child, which is then killed. Returns its exit code, or 128 + the
    /// signal that ended it. May be called again.
    int finish() noexcept;
    /// Exit code when the child has ended already; never waits.
    [[nodiscard]] std::optional<int> ended() noexcept;

private:
    UniqueFd socket_;
    pid_t id_ = -1;
    std::optional<int> exit_code_;
};

/// Path of one of the project's programs: beside the running executable, else in $SCRIBECELL_ROOT/build/release/bin.
/// nullopt when it is in neither.
[[nodiscard]] std::optional<std::filesystem::path> find_program(const std::string& name);
/// Root folder of the project's files (examples, tests/bench): $SCRIBECELL_ROOT, else the nearest folder above the
/// running executable that holds examples/. nullopt when there is none.
[[nodiscard]] std::optional<std::filesystem::path> find_project_root();

}  // namespace sc::host
