// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace sc::test {

/// A program of this build, run by a test. stdout and stderr are read while it runs.
class Program {
public:
    /// `name` is looked for in the build's bin folder, unless it begins with a slash.
    Program(const std::string& name, const std::vector<std::string>& arguments);
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;
    /// Kills what still runs.
    ~Program();

    /// Reads until `text` has appeared on stderr (`err`) or stdout; false when the program ended first.
    bool wait_for_err(const std::string& text);
    bool wait_for_out(const std::string& text);
    void signal(int number) const;
    /// Reads to the end; exit code, or 128 + the signal that ended it.
    int wait();

    [[nodiscard]] const std::string& out() const { return out_; }
    [[nodiscard]] const std::string& err() const { return err_; }

private:
    bool read_some();

    pid_t id_ = -1;
    int out_fd_ = -1;
    int err_fd_ = -1;
    std::string out_;
    std::string err_;
    int exit_code_ = -1;
};

/// An empty folder for the running test.
[[nodiscard]] std::filesystem::path fresh_folder();
[[nodiscard]] std::string read_file(const std::filesystem::path& file);
void write_file(const std::filesystem::path& file, const std::string& text);
/// `text` with the first `from` replaced; the test fails when it is not there.
[[nodiscard]] std::string replaced(const std::string& text, const std::string& from, const std::string& to);

/// This process becomes the parent of orphans, so that the end of a cell whose host was killed can be waited for.
void adopt_orphans();
/// Waits for the end of every child.
void wait_for_orphans();

}  // namespace sc::test
