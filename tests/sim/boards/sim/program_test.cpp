// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sc::sim {
namespace {

const std::string kProgram = std::string(SC_BINARY_DIR) + "/bin/scribecell-cell";
const std::string kWorld = std::string(SC_SOURCE_DIR) + "/boards/sim/world/default/world.toml";

/// The program with its stdout in a pipe.
class Program {
public:
    explicit Program(std::vector<std::string> arguments) {
        std::array<int, 2> pipe{};
        EXPECT_EQ(::pipe(pipe.data()), 0);
        id_ = ::fork();
        if (id_ == 0) {
            ::dup2(pipe[1], STDOUT_FILENO);
            std::vector<char*> words{const_cast<char*>(kProgram.c_str())};
            for (std::string& argument : arguments) {
                words.push_back(argument.data());
            }
            words.push_back(nullptr);
            ::execv(kProgram.c_str(), words.data());
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
    std::string line() const {
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

class CellProgram : public testing::Test {
protected:
    CellProgram() {
        std::string pattern = (std::filesystem::temp_directory_path() / "scribecell-XXXXXX").string();
        EXPECT_NE(::mkdtemp(pattern.data()), nullptr);
        out_ = pattern;
    }
    ~CellProgram() override { std::filesystem::remove_all(out_); }
    [[nodiscard]] nlohmann::json report() const {
        std::ifstream stream(out_ / "cell.json");
        return nlohmann::json::parse(stream, nullptr, false);
    }
    /// Waits for the first byte (the cell says its status unasked or not at all: connection is what is tested).
    static bool connected(int file) {
        const std::string garbage("\x00\x01\x02\x00", 4);
        return ::write(file, garbage.data(), garbage.size()) == 4;
    }
    std::filesystem::path out_;
};

TEST_F(CellProgram, PtyIsNamedServedAndEndedBySigterm) {
    Program program({"--pty", "--out", out_.string(), "--world", kWorld, "--speed", "20"});
    const std::string path = program.line();
    for (int client = 0; client < 2; ++client) {
        const int file = ::open(path.c_str(), O_RDWR | O_NOCTTY);
        ASSERT_GE(file, 0) << path;
        EXPECT_TRUE(connected(file));
        ::close(file);
    }
    program.signal(SIGTERM);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_TRUE(report().contains("state"));
    EXPECT_TRUE(std::filesystem::exists(out_ / "pulses.trace"));
}

TEST_F(CellProgram, TcpServesOneClientAfterAnotherUntilSigint) {
    Program program({"--tcp", "0", "--out", out_.string(), "--world", kWorld});
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(program.line())));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    for (int client = 0; client < 2; ++client) {
        const int file = ::socket(AF_INET, SOCK_STREAM, 0);
        ASSERT_EQ(::connect(file, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
        EXPECT_TRUE(connected(file));
        ::close(file);
    }
    program.signal(SIGINT);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_EQ(report()["pulses"], 0);
}

TEST_F(CellProgram, LockStepRunsOutAndReportsWhenTheHostIsGone) {
    std::array<int, 2> sockets{};
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, sockets.data()), 0);
    ::fcntl(sockets[0], F_SETFD, FD_CLOEXEC);
    Program program({"--lockstep-fd", std::to_string(sockets[1]), "--out", out_.string(), "--world", kWorld});
    ::close(sockets[1]);
    const std::array<std::uint8_t, 12> request{8, 0, 0, 0, 0x80, 0x96, 0x98, 0, 0, 0, 0, 0};  // until 10 ms
    ASSERT_EQ(::send(sockets[0], request.data(), request.size(), 0), 12);
    std::array<std::uint8_t, 12> answer{};
    ASSERT_EQ(::recv(sockets[0], answer.data(), answer.size(), MSG_WAITALL), 12);
    ::close(sockets[0]);
    EXPECT_EQ(program.wait(), 0);
    const nlohmann::json json = report();
    EXPECT_EQ(json["faults"].size(), 0U);
    EXPECT_EQ(json["script_events"].size(), 0U);
    EXPECT_GT(json["errors"].size(), 20U);
    EXPECT_EQ(json["command_trace_sha256"], "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST_F(CellProgram, BadInputEndsWithTwoAndWritesNothing) {
    std::ofstream(out_ / "script.txt") << "at 1 estop ajar\n";
    std::ofstream(out_ / "world.toml") << "base = \"" << kWorld << "\"\n[galvo]\nwobble = 3\n";
    const std::string out = (out_ / "run").string();
    EXPECT_EQ(Program({"--out", out}).wait(), 2);
    EXPECT_EQ(Program({"--pty", "--tcp", "0", "--out", out}).wait(), 2);
    EXPECT_EQ(Program({"--pty", "--baud", "12", "--out", out}).wait(), 2);
    EXPECT_EQ(Program({"--pty", "--world", "/nowhere.toml", "--out", out}).wait(), 2);
    EXPECT_EQ(Program({"--pty", "--world", (out_ / "world.toml").string(), "--out", out}).wait(), 2);
    EXPECT_EQ(Program({"--pty", "--world", kWorld, "--script", (out_ / "script.txt").string(), "--out", out}).wait(),
              2);
    EXPECT_FALSE(std::filesystem::exists(std::filesystem::path(out) / "pulses.trace.part"));
    EXPECT_EQ(Program({"--help"}).wait(), 0);
}

}  // namespace
}  // namespace sc::sim
