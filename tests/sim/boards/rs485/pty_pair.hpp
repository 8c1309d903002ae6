// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

namespace sc {

/// A pseudo-terminal in raw mode: this side by number, the other by name. The other side is held open, so that neither
/// end ever sees a hang-up.
class PtyPair {
public:
    PtyPair() : here_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
        std::array<char, 128> path{};
        if (here_ < 0 || ::grantpt(here_) != 0 || ::unlockpt(here_) != 0 ||
            ::ptsname_r(here_, path.data(), path.size()) != 0) {
            throw std::runtime_error("no pseudo-terminal");
        }
        name_ = path.data();
        there_ = ::open(name_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
        termios settings{};
        if (there_ < 0 || ::tcgetattr(there_, &settings) != 0) {
            throw std::runtime_error("no pseudo-terminal");
        }
        ::cfmakeraw(&settings);
        (void)::tcsetattr(there_, TCSANOW, &settings);
    }
    PtyPair(const PtyPair&) = delete;
    PtyPair& operator=(const PtyPair&) = delete;
    ~PtyPair() {
        ::close(there_);
        ::close(here_);
    }
    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] int here() const { return here_; }

    void send(const std::vector<std::uint8_t>& bytes) const {
        if (::write(here_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
            throw std::runtime_error("cannot write to the pseudo-terminal");
        }
    }
    /// Appends what has come; false if nothing comes within `wait`.
    bool receive(std::vector<std::uint8_t>& out, std::chrono::milliseconds wait) const {
        pollfd state{here_, POLLIN, 0};
        if (::poll(&state, 1, static_cast<int>(wait.count())) <= 0) {
            return false;
        }
        std::array<std::uint8_t, 256> buffer{};
        const ssize_t n = ::read(here_, buffer.data(), buffer.size());
        out.insert(out.end(), buffer.begin(), buffer.begin() + std::max<ssize_t>(n, 0));
        return n > 0;
    }

private:
    int here_;
    int there_ = -1;
    std::string name_;
};

}  // namespace sc
