// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cerrno>
#include <cstdlib>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "boards/port/port.hpp"

namespace sc::port {
namespace {

int checked(int result, const char* what) {
    if (result < 0) {
        throw std::system_error(errno, std::generic_category(), what);
    }
    return result;
}

class Pty final : public Port {
public:
    Pty() : master_(checked(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK), "posix_openpt")) {
        checked(::grantpt(master_), "grantpt");
        checked(::unlockpt(master_), "unlockpt");
        std::array<char, 128> path{};
        if (const int error = ::ptsname_r(master_, path.data(), path.size()); error != 0) {
            throw std::system_error(error, std::generic_category(), "ptsname_r");
        }
        name_ = path.data();
        make_raw();
    }
    Pty(const Pty&) = delete;
    Pty& operator=(const Pty&) = delete;
    ~Pty() override { ::close(master_); }

    [[nodiscard]] std::string name() const override { return name_; }
    /// While no client has the slave open, poll would return at once for ever.
    [[nodiscard]] int file() const override { return connected() ? master_ : -1; }

    std::size_t receive(std::span<std::uint8_t> out) override {
        const ssize_t n = ::read(master_, out.data(), out.size());
        return n > 0 ? static_cast<std::size_t>(n) : 0;
    }

    /// Nobody reads: the line's buffer is full, and these bytes are lost as on a real line.
    std::size_t send(std::span<const std::uint8_t> bytes) override {
        const ssize_t n = connected() ? ::write(master_, bytes.data(), bytes.size()) : 0;
        return n > 0 ? static_cast<std::size_t>(n) : 0;
    }

private:
    /// The slave is opened once and closed again: only then does the master report a hang-up while nobody is there.
    void make_raw() const {
        const int slave = checked(::open(name_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC), "open the pseudo-terminal");
        termios settings{};
        const bool got = ::tcgetattr(slave, &settings) == 0;
        ::cfmakeraw(&settings);
        const bool set = got && ::tcsetattr(slave, TCSANOW, &settings) == 0;
        ::close(slave);
        if (!set) {
            throw std::system_error(errno, std::generic_category(), "raw mode");
        }
    }

    [[nodiscard]] bool connected() const {
        pollfd state{master_, 0, 0};
        return ::poll(&state, 1, 0) >= 0 && (state.revents & POLLHUP) == 0;
    }

    int master_;
    std::string name_;
};

}  // namespace

std::unique_ptr<Port> open_pty() { return std::make_unique<Pty>(); }

}  // namespace sc::port
