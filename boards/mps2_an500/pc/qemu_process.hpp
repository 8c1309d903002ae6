// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <sys/types.h>

namespace sc::mps2_an500 {

/// What is missing or wrong before the core has started: image, QEMU, or that they belong together.
class SetupError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// qemu-system-arm as a child that ends with its owner: killed by the destructor, and by the kernel when the thread
/// that started it ends in any other way. In a process group of its own, so that Ctrl-C reaches the owner alone.
class QemuProcess {
public:
    /// Starts `program` (looked up in PATH when it holds no slash) with `arguments`. Its stderr is ours, its stdin and
    /// stdout are closed. Throws SetupError when it cannot be started.
    QemuProcess(const std::string& program, const std::vector<std::string>& arguments);
    QemuProcess(const QemuProcess&) = delete;
    QemuProcess& operator=(const QemuProcess&) = delete;
    ~QemuProcess();

    [[nodiscard]] pid_t id() const noexcept { return id_; }
    /// How it ended ("code 1", "signal 9"), if it has. Never waits.
    [[nodiscard]] std::optional<std::string> ended() noexcept;

private:
    pid_t id_ = -1;
    std::optional<std::string> end_;
};

}  // namespace sc::mps2_an500
