// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/host/cli/program.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <set>
#include <system_error>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace sc::test {
namespace {

struct Pipe {
    std::array<int, 2> ends{-1, -1};
    Pipe() { EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0); }
};

bool drain(int& fd, std::string& text) {
    std::array<char, 4096> chunk{};
    const ssize_t n = ::read(fd, chunk.data(), chunk.size());
    if (n > 0) {
        text.append(chunk.data(), static_cast<std::size_t>(n));
        return true;
    }
    if (n < 0 && errno == EINTR) {
        return true;
    }
    ::close(fd);
    fd = -1;
    return false;
}

/// What a program that has ended has left in the pipe; others may still hold its other end.
void drain_rest(int& fd, std::string& text) {
    if (fd >= 0) {
        ::fcntl(fd, F_SETFL, O_NONBLOCK);
    }
    while (fd >= 0 && drain(fd, text)) {
    }
}

}  // namespace

Program::Program(const std::string& name, const std::vector<std::string>& arguments) {
    const std::string path = name.starts_with("/") ? name : std::string(SC_BINARY_DIR) + "/bin/" + name;
    ::setenv("SCRIBECELL_ROOT", SC_SOURCE_DIR, 1);
    const Pipe out;
    const Pipe err;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, out.ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, err.ends[1], STDERR_FILENO);
    std::vector<std::string> words{path};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) {
        argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    EXPECT_EQ(posix_spawn(&id_, path.c_str(), &actions, nullptr, argv.data(), environ), 0) << path;
    posix_spawn_file_actions_destroy(&actions);
    ::close(out.ends[1]);
    ::close(err.ends[1]);
    out_fd_ = out.ends[0];
    err_fd_ = err.ends[0];
}

Program::~Program() {
    if (exit_code_ < 0) {
        signal(SIGKILL);
        wait();
    }
}

bool Program::read_some() {
    std::array<pollfd, 2> files{pollfd{out_fd_, POLLIN, 0}, pollfd{err_fd_, POLLIN, 0}};
    if (out_fd_ < 0 && err_fd_ < 0) {
        return false;
    }
    if (::poll(files.data(), files.size(), -1) < 0) {
        return errno == EINTR;
    }
    if (files[0].revents != 0) {
        drain(out_fd_, out_);
    }
    if (files[1].revents != 0) {
        drain(err_fd_, err_);
    }
    return true;
}

bool Program::wait_for_err(const std::string& text) {
    while (err_.find(text) == std::string::npos && read_some()) {
    }
    return err_.find(text) != std::string::npos;
}

bool Program::wait_for_out(const std::string& text) {
    while (out_.find(text) == std::string::npos && read_some()) {
    }
    return out_.find(text) != std::string::npos;
}

void Program::signal(int number) const { ::kill(id_, number); }

int Program::wait() {
    // A cell that outlives its host keeps stderr open: the program's own end is what counts.
    int status = 0;
    while (exit_code_ < 0) {
        const pid_t ended = ::waitpid(id_, &status, WNOHANG);
        if (ended == id_) {
            exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        } else if (!read_some()) {
            ::waitpid(id_, &status, 0);
            exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        }
    }
    drain_rest(out_fd_, out_);
    drain_rest(err_fd_, err_);
    return exit_code_;
}

namespace {

/// Folders of the tests of this process; they go with it, unless a test has failed and somebody wants to look.
class Folders {
public:
    Folders() = default;
    Folders(const Folders&) = delete;
    Folders& operator=(const Folders&) = delete;
    ~Folders() {
        if (::getpid() != owner_ || ::testing::UnitTest::GetInstance()->Failed()) {
            return;
        }
        for (const std::filesystem::path& folder : made_) {
            std::error_code ignored;
            std::filesystem::remove_all(folder, ignored);
        }
    }
    void add(const std::filesystem::path& folder) { made_.insert(folder); }

private:
    pid_t owner_ = ::getpid();
    std::set<std::filesystem::path> made_;
};

}  // namespace

std::filesystem::path fresh_folder() {
    static Folders folders;
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(info->test_suite_name()) + "_" + info->name() + "_" + std::to_string(::getpid());
    std::replace(name.begin(), name.end(), '/', '_');
    const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / ("scribecell_" + name);
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    folders.add(folder);
    return folder;
}

std::string read_file(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    EXPECT_TRUE(in.good()) << file;
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write_file(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

std::string replaced(const std::string& text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.substr(0, at) + to + text.substr(at + from.size());
}

void adopt_orphans() { ASSERT_EQ(::prctl(PR_SET_CHILD_SUBREAPER, 1), 0); }

void wait_for_orphans() {
    while (::waitpid(-1, nullptr, 0) > 0 || errno == EINTR) {
    }
}

}  // namespace sc::test
