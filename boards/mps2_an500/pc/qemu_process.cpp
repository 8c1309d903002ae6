// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an500/pc/qemu_process.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sc::mps2_an500 {
namespace {

std::string end_text(int status) {
    return WIFEXITED(status) ? "code " + std::to_string(WEXITSTATUS(status))
                             : "signal " + std::to_string(WTERMSIG(status));
}

/// In the child: nothing but system calls until exec. Writes errno to `failure` when exec fails.
[[noreturn]] void become(char* const* words, pid_t parent, int failure) noexcept {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::setpgid(0, 0);
    if (::getppid() == parent) {
        const int nothing = ::open("/dev/null", O_RDWR);
        if (nothing >= 0) {
            ::dup2(nothing, STDIN_FILENO);
            ::dup2(nothing, STDOUT_FILENO);
            ::execvp(words[0], words);
        }
    }
    const int number = errno;
    (void)!::write(failure, &number, sizeof number);
    ::_exit(127);
}

[[noreturn]] void refuse(const std::string& program, int number) {
    throw SetupError("cannot start " + program + ": " + std::strerror(number) +
                     (number == ENOENT ? "; install the package qemu-system-arm (./run --board m7 does)" : ""));
}

}  // namespace

QemuProcess::QemuProcess(const std::string& program, const std::vector<std::string>& arguments) {
    std::vector<std::string> words{program};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) {
        argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    std::array<int, 2> failure{};
    if (::pipe2(failure.data(), O_CLOEXEC) != 0) {
        refuse(program, errno);
    }
    const pid_t parent = ::getpid();
    id_ = ::fork();
    if (id_ == 0) {
        become(argv.data(), parent, failure[1]);
    }
    const int fork_error = errno;
    ::close(failure[1]);
    int number = 0;
    const bool failed = id_ > 0 && ::read(failure[0], &number, sizeof number) == sizeof number;
    ::close(failure[0]);
    if (id_ < 0) {
        refuse(program, fork_error);
    }
    if (failed) {
        ::waitpid(id_, nullptr, 0);
        refuse(program, number);
    }
}

QemuProcess::~QemuProcess() {
    if (!end_) {
        ::kill(id_, SIGKILL);
        while (::waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
}

std::optional<std::string> QemuProcess::ended() noexcept {
    int status = 0;
    if (!end_ && ::waitpid(id_, &status, WNOHANG) == id_) {
        end_ = end_text(status);
    }
    return end_;
}

}  // namespace sc::mps2_an500
