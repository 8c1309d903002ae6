// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "rt_cell.hpp"
#include "tests/sim/boards/sim/cell_job.hpp"

namespace sc::linux_rt {
namespace {

using namespace std::chrono_literals;

const std::string kPrograms = std::string(SC_BINARY_DIR) + "/bin/";
constexpr int kInherited = 200;  // no file of this process has that number

/// A program with its stdout in a pipe, and one socket handed over.
class Program {
public:
    Program(const std::string& name, std::vector<std::string> words, int socket = -1,
            const std::vector<std::string>& environment = {}) {
        std::array<int, 2> pipe{};
        EXPECT_EQ(::pipe2(pipe.data(), O_CLOEXEC), 0);
        const std::string path = kPrograms + name;
        words.insert(words.begin(), path);
        std::vector<char*> arguments;
        for (std::string& word : words) {
            arguments.push_back(word.data());
        }
        arguments.push_back(nullptr);
        id_ = ::fork();
        if (id_ == 0) {
            ::dup2(pipe[1], STDOUT_FILENO);
            if (socket >= 0) {
                ::dup2(socket, kInherited);
            }
            for (const std::string& one : environment) {
                ::putenv(const_cast<char*>(one.c_str()));
            }
            ::execv(path.c_str(), arguments.data());
            ::_exit(127);
        }
        ::close(pipe[1]);
        out_ = pipe[0];
    }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;
    ~Program() {
        if (id_ > 0) {
            ::kill(id_, SIGKILL);
            (void)wait();
        }
        ::close(out_);
    }
    [[nodiscard]] std::string line() const {
        std::string text;
        char c = 0;
        while (::read(out_, &c, 1) == 1 && c != '\n') {
            text += c;
        }
        return text;
    }
    void signal(int number) const { ::kill(id_, number); }
    int wait() {
        int status = 0;
        ::waitpid(id_, &status, 0);
        id_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }

private:
    pid_t id_ = -1;
    int out_ = -1;
};

/// Drives whose time is that of the SYNCs on their bus.
class DriveThread {
public:
    DriveThread() : files_(packet_pair()), thread_([this] { run(); }) {}
    DriveThread(const DriveThread&) = delete;
    DriveThread& operator=(const DriveThread&) = delete;
    ~DriveThread() {
        stop_ = true;
        thread_.join();
        ::close(files_[0]);
    }
    [[nodiscard]] int socket() const { return files_[0]; }

private:
    void run() {
        const MachineConfig machine = reference_machine();
        const sim::WorldSpec world = sim::read_world_spec(sim::default_cell().world);
        BusOfDrives bus(machine, world, files_[1]);
        std::int64_t tick = 0;
        while (!stop_) {
            pollfd wait{files_[1], POLLIN, 0};
            if (::poll(&wait, 1, 20) > 0) {
                bus.play(tick);
                ++tick;
            }
        }
    }
    std::array<int, 2> files_;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

class RtProgram : public testing::Test {
protected:
    RtProgram() {
        std::string pattern = (std::filesystem::temp_directory_path() / "scribecell-XXXXXX").string();
        EXPECT_NE(::mkdtemp(pattern.data()), nullptr);
        folder_ = pattern;
    }
    ~RtProgram() override { std::filesystem::remove_all(folder_); }
    [[nodiscard]] static std::vector<std::string> words(const std::vector<std::string>& more) {
        std::vector<std::string> all{"--drive-bus",    "fd:" + std::to_string(kInherited),
                                     "--link",         "tcp:0",
                                     "--lines-closed", "--no-rt",
                                     "--pace",         "drives",
                                     "--json"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    std::filesystem::path folder_;
};

TEST_F(RtProgram, RunsDrivesAndEventDeviceTellsWhatItMeasuresAndEndsWhenAsked) {
    const std::string socket = folder_ / "events.socket";
    const std::string notify = folder_ / "notify";
    const int manager = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    notify.copy(static_cast<char*>(address.sun_path), notify.size());
    ASSERT_EQ(::bind(manager, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    timeval patience{5, 0};
    ::setsockopt(manager, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);

    Program events("scribecell-events", {socket, "--out", folder_ / "events.trace", "--once", "--json"});
    for (int i = 0; i < 500 && !std::filesystem::exists(socket); ++i) {
        std::this_thread::sleep_for(10ms);
    }
    const DriveThread drives;
    Program rt("scribecell-rt", words({"--events", socket}), drives.socket(),
               {"NOTIFY_SOCKET=" + notify, "WATCHDOG_USEC=1000000"});
    std::array<char, 64> said{};
    ASSERT_GT(::recv(manager, said.data(), said.size(), 0), 0);
    EXPECT_STREQ(said.data(), "READY=1");

    nlohmann::json now;
    for (int i = 0; i < 100; ++i) {
        std::this_thread::sleep_for(50ms);
        rt.signal(SIGUSR1);
        now = nlohmann::json::parse(rt.line(), nullptr, false);
        ASSERT_TRUE(now.is_object());
        if (now["state"] == "disabled") {
            break;
        }
    }
    EXPECT_EQ(now["state"], "disabled") << now.dump();
    EXPECT_GT(now["late"]["count"], 0);
    EXPECT_GT(now["events"]["windows"], 0);
    bool watched = false;
    while (!watched) {
        said = {};
        ASSERT_GT(::recv(manager, said.data(), said.size(), 0), 0);
        watched = std::string(said.data()) == "WATCHDOG=1";
    }
    rt.signal(SIGTERM);
    const nlohmann::json end = nlohmann::json::parse(rt.line(), nullptr, false);
    EXPECT_EQ(rt.wait(), 0);
    ASSERT_TRUE(end.is_object());
    EXPECT_EQ(end["allocations"], 0);
    EXPECT_EQ(end["drives"]["unsent"], 0);
    EXPECT_EQ(end["drives"]["buses"][0]["failed"], 0);
    EXPECT_EQ(events.wait(), 0);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "events.trace"));
    std::ifstream report(folder_ / "events.trace.json");
    const nlohmann::json played = nlohmann::json::parse(report, nullptr, false);
    EXPECT_EQ(played["windows"], end["events"]["windows"]);
    EXPECT_EQ(played["gaps"], 0);
    EXPECT_EQ(played["pulses"], 0);
    ::close(manager);
}

TEST_F(RtProgram, BadInputEndsWithTwoAndSaysWhat) {
    for (const std::vector<std::string>& bad : std::vector<std::vector<std::string>>{
             {"--drive-bus", "vcan0", "--link", "tcp:0", "--lines-closed", "--no-rt"},
             {"--drive-bus", "can:can_not_here", "--link", "tcp:0", "--lines-closed", "--no-rt"},
             {"--drive-bus", "can:a,can:b,can:c", "--link", "tcp:0", "--lines-closed", "--no-rt"},
             {"--drive-bus", "can:a", "--link", "tcp:0"},
             {"--drive-bus", "can:a", "--link", "tcp:0", "--lines-closed", "--gate", "gpio"},
             {"--drive-bus", "can:a", "--link", "tcp:0", "--lines-closed", "--slow", "3"}}) {
        EXPECT_EQ(Program("scribecell-rt", bad).wait(), 2);
    }
    EXPECT_EQ(Program("scribecell-events", {}).wait(), 2);
}

TEST_F(RtProgram, AnEventDeviceThatIsNotThereIsSaid) {
    const std::array<int, 2> files = packet_pair();
    EXPECT_EQ(Program("scribecell-rt", words({"--events", folder_ / "none"}), files[0]).wait(), 2);
    ::close(files[0]);
    ::close(files[1]);
}

}  // namespace
}  // namespace sc::linux_rt
