// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/child_process.hpp"

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>

extern char** environ;

namespace sc::host {
namespace {

constexpr int kEndWaitMs = 20'000;
constexpr int kPollMs = 2;

/// Spawn settings as an object, so that they are freed whatever happens.
class SpawnSettings {
public:
    explicit SpawnSettings(int child_socket) {
        posix_spawn_file_actions_init(&actions_);
        posix_spawnattr_init(&attributes_);
        posix_spawn_file_actions_adddup2(&actions_, child_socket, ChildProcess::kChildSocket);
        // A group of its own, and the signals as a fresh program expects them.
        sigset_t defaults;
        sigemptyset(&defaults);
        sigaddset(&defaults, SIGPIPE);
        posix_spawnattr_setsigdefault(&attributes_, &defaults);
        posix_spawnattr_setpgroup(&attributes_, 0);
        posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    }
    SpawnSettings(const SpawnSettings&) = delete;
    SpawnSettings& operator=(const SpawnSettings&) = delete;
    ~SpawnSettings() {
        posix_spawn_file_actions_destroy(&actions_);
        posix_spawnattr_destroy(&attributes_);
    }
    [[nodiscard]] const posix_spawn_file_actions_t* actions() const { return &actions_; }
    [[nodiscard]] const posix_spawnattr_t* attributes() const { return &attributes_; }

private:
    posix_spawn_file_actions_t actions_{};
    posix_spawnattr_t attributes_{};
};

int exit_code_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

std::filesystem::path executable_folder() {
    std::error_code failed;
    return std::filesystem::read_symlink("/proc/self/exe", failed).parent_path();
}

}  // namespace

ChildProcess::ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments) {
    std::array<int, 2> pair{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair.data()) != 0) {
        throw std::system_error(errno, std::generic_category(), "socketpair");
    }
    socket_.reset(pair[0]);
    const UniqueFd child(pair[1]);
    std::vector<std::string> words{program.string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) {
        argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    const SpawnSettings settings(child.get());
    const int failed =
        posix_spawn(&id_, program.c_str(), settings.actions(), settings.attributes(), argv.data(), environ);
    if (failed != 0) {
        throw std::system_error(failed, std::generic_category(), "cannot start " + program.string());
    }
}

ChildProcess::~ChildProcess() { finish(); }

std::optional<int> ChildProcess::ended() noexcept {
    int status = 0;
    if (!exit_code_ && ::waitpid(id_, &status, WNOHANG) == id_) {
        exit_code_ = exit_code_of(status);
    }
    return exit_code_;
}

int ChildProcess::finish() noexcept {
    socket_.reset();
    for (int waited = 0; !ended() && waited < kEndWaitMs; waited += kPollMs) {
        std::this_thread::sleep_for(std::chrono::milliseconds(kPollMs));
    }
    if (!ended()) {
        ::kill(id_, SIGKILL);
        int status = 0;
        while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
        }
        exit_code_ = exit_code_of(status);
    }
    return *exit_code_;
}

std::optional<std::filesystem::path> find_program(const std::string& name) {
    std::vector<std::filesystem::path> candidates{executable_folder() / name};
    if (const char* root = std::getenv("SCRIBECELL_ROOT")) {
        candidates.push_back(std::filesystem::path(root) / "build/release/bin" / name);
    }
    for (const auto& candidate : candidates) {
        if (::access(candidate.c_str(), X_OK) == 0) {
            return candidate;
        }
    }
    return std::nullopt;
}

std::optional<std::filesystem::path> find_project_root() {
    if (const char* root = std::getenv("SCRIBECELL_ROOT")) {
        return std::filesystem::path(root);
    }
    std::error_code failed;
    for (auto folder = executable_folder(); !folder.empty(); folder = folder.parent_path()) {
        if (std::filesystem::is_directory(folder / "examples", failed)) {
            return folder;
        }
        if (folder == folder.parent_path()) {
            break;
        }
    }
    return std::nullopt;
}

}  // namespace sc::host
