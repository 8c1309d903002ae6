// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/program.hpp"

#include <array>
#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/unique_fd.hpp"

extern char** environ;

namespace sc::host {
namespace {

[[noreturn]] void fail(int error, const std::string& what) {
    throw std::system_error(error, std::generic_category(), what);
}

/// The words that exec and spawn want, pointing into itself.
class Words {
public:
    Words(const std::filesystem::path& program, const std::vector<std::string>& arguments) : words_{program.string()} {
        words_.insert(words_.end(), arguments.begin(), arguments.end());
        for (std::string& word : words_) {
            pointers_.push_back(word.data());
        }
        pointers_.push_back(nullptr);
    }
    Words(const Words&) = delete;
    Words& operator=(const Words&) = delete;
    [[nodiscard]] char* const* data() const noexcept { return pointers_.data(); }

private:
    std::vector<std::string> words_;
    std::vector<char*> pointers_;
};

std::string read_to_end(int file) {
    std::string text;
    std::array<char, 4096> buffer{};
    while (true) {
        const ssize_t n = ::read(file, buffer.data(), buffer.size());
        if (n > 0) {
            text.append(buffer.data(), static_cast<std::size_t>(n));
        } else if (n == 0 || errno != EINTR) {
            return text;
        }
    }
}

int wait_for(pid_t id) {
    int status = 0;
    while (::waitpid(id, &status, 0) < 0) {
        if (errno != EINTR) {
            fail(errno, "waitpid");
        }
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

std::filesystem::path required_program(const std::string& name) {
    const auto found = find_program(name);
    if (!found) {
        throw CellError("the program " + name + " is not there: build it (./run does), or set SCRIBECELL_ROOT");
    }
    return *found;
}

void become_program(const std::filesystem::path& program, const std::vector<std::string>& arguments) {
    const Words words(program, arguments);
    ::execv(program.c_str(), words.data());
    fail(errno, "cannot start " + program.string());
}

ProgramOutput run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                          ProgramErrors errors) {
    std::array<int, 2> pipe{};
    if (::pipe2(pipe.data(), O_CLOEXEC) != 0) {
        fail(errno, "pipe");
    }
    const UniqueFd reader(pipe[0]);
    UniqueFd writer(pipe[1]);
    const Words words(program, arguments);
    posix_spawn_file_actions_t actions{};
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, writer.get(), STDOUT_FILENO);
    if (errors == ProgramErrors::dropped) {
        posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    }
    pid_t id = -1;
    const int failed = posix_spawn(&id, program.c_str(), &actions, nullptr, words.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    writer.reset(-1);
    if (failed != 0) {
        fail(failed, "cannot start " + program.string());
    }
    ProgramOutput output;
    output.text = read_to_end(reader.get());
    output.exit_code = wait_for(id);
    return output;
}

}  // namespace sc::host
