// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "image_path.hpp"

namespace sc::mps2_an500 {
namespace {

using std::chrono::milliseconds;

/// What the exception says that `work` throws; empty if it throws none.
std::string failure_of(const std::function<void()>& work) {
    try {
        work();
    } catch (const SetupError& error) {
        return std::string("setup: ") + error.what();
    } catch (const std::runtime_error& error) {
        return error.what();
    }
    return {};
}

void expect_parts(const std::string& text, std::initializer_list<const char*> parts) {
    for (const char* part : parts) {
        EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' in: " << text;
    }
}

class Core : public testing::Test {
protected:
    /// Sends `signal` and waits until it has taken effect in every thread: until then a tick may still be answered.
    void strike(int signal, int effect) const {
        ASSERT_EQ(::kill(core_.process(), signal), 0);
        siginfo_t info{};
        ASSERT_EQ(::waitid(P_PID, static_cast<id_t>(core_.process()), &info, effect | WNOWAIT), 0);
    }
    void tick() {
        core_.tick(inputs_, outputs_);
        ++inputs_.tick;
    }
    static M7Options options() {
        M7Options options = image_under_test();
        options.stall_timeout = milliseconds(4000);
        return options;
    }
    M7Controller core_{options(), reference_machine(), 1};
    ServoInputs inputs_;
    ServoOutputs outputs_;
};

TEST_F(Core, KilledQemuIsNoticed) {
    tick();
    strike(SIGKILL, WEXITED);
    expect_parts(failure_of([this] { tick(); }), {"QEMU ended", "signal 9"});
}

TEST_F(Core, StoppedQemuIsNoticed) {
    tick();
    strike(SIGSTOP, WSTOPPED);
    expect_parts(failure_of([this] { tick(); }), {"has not answered for 4000 ms", "try again"});
}

TEST_F(Core, LeavesAFaultRecord) {
    tick();
    const std::string text = failure_of([this] { core_.provoke_fault(); });
    // An undefined instruction is a usage fault (6) with UNDEFINSTR, bit 16.
    expect_parts(text, {"exception 6", "CFSR 0x10000,", "addr2line"});
    expect_parts(failure_of([this] { tick(); }), {"exception 6"});
}

TEST_F(Core, FullStackIsAFaultAndNoSilentDamage) {
    // The write below the data RAM is a memory fault (4), and so is the fault's own stack frame.
    expect_parts(failure_of([this] { core_.exhaust_stack(); }), {"exception 4", "sp 0x1fff"});
}

TEST_F(Core, EndsWithItsOwner) {
    // The owner is killed hard: no destructor runs. Its orphan becomes ours and must end by itself.
    ::prctl(PR_SET_CHILD_SUBREAPER, 1);
    std::array<int, 2> ready{};
    ASSERT_EQ(::pipe(ready.data()), 0);
    const pid_t owner = ::fork();
    if (owner == 0) {
        const M7Controller mine(options(), reference_machine(), 1);
        const pid_t qemu = mine.process();
        (void)!::write(ready[1], &qemu, sizeof qemu);
        ::pause();
        ::_exit(0);
    }
    pid_t qemu = 0;
    ASSERT_EQ(::read(ready[0], &qemu, sizeof qemu), static_cast<ssize_t>(sizeof qemu));
    ::kill(owner, SIGKILL);
    ::waitpid(owner, nullptr, 0);
    int status = 0;
    pid_t ended = 0;
    for (int i = 0; i < 500 && ended == 0; ++i) {
        ended = ::waitpid(qemu, &status, WNOHANG);
        std::this_thread::sleep_for(milliseconds(10));
    }
    EXPECT_EQ(ended, qemu);
    EXPECT_TRUE(WIFSIGNALED(status));
    ::close(ready[0]);
    ::close(ready[1]);
}

TEST(M7Start, RefusesWhatIsNotThere) {
    M7Options options = image_under_test();
    options.image = "/nonexistent/image.elf";
    const auto start = [&options] { const M7Controller core(options, reference_machine(), 1); };
    expect_parts(failure_of(start), {"setup: ", "no image", "/nonexistent/image.elf", "cmake --preset m7"});
    options = image_under_test();
    options.qemu = "qemu-system-nowhere";
    expect_parts(failure_of(start), {"setup: ", "qemu-system-nowhere", "install the package"});
}

TEST(M7Start, RefusesAFileThatIsNoImage) {
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "no_image.elf";
    std::ofstream(file) << "no image";
    const M7Options options{.image = file};
    const std::string text = failure_of([&options] { const M7Controller core(options, reference_machine(), 1); });
    std::filesystem::remove(file);
    expect_parts(text, {"no_image.elf", "no ELF file for Arm", "cmake --preset m7"});
}

TEST(M7Start, RefusesAnImageOfOtherSources) {
    // The build's number is a constant of the image: change it there.
    std::ifstream in(image_under_test().image, std::ios::binary);
    std::string elf((std::istreambuf_iterator<char>(in)), {});
    const std::uint64_t id = M7Controller::build_id();
    std::string bytes(sizeof id, '\0');
    std::memcpy(bytes.data(), &id, sizeof id);
    const std::size_t at = elf.find(bytes);
    ASSERT_NE(at, std::string::npos) << "image and test are of different sources";
    elf[at] = static_cast<char>(elf[at] ^ 1);
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "other_image.elf";
    std::ofstream(file, std::ios::binary) << elf;
    const M7Options options{.image = file};
    const std::string text = failure_of([&options] { const M7Controller core(options, reference_machine(), 1); });
    std::filesystem::remove(file);
    expect_parts(text, {"setup: ", "does not belong to this program", "different sources", "cmake --preset m7"});
}

TEST(M7Start, MachineThatTheCoreCannotTakeHaltsIt) {
    MachineConfig machine = reference_machine();
    machine.control_period_ns = 0;
    const std::string text = failure_of([&machine] { const M7Controller core(image_under_test(), machine, 1); });
    expect_parts(text, {"does not understand"});
}

}  // namespace
}  // namespace sc::mps2_an500
