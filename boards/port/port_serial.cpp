// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cerrno>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include "boards/port/port.hpp"

namespace sc::port {
namespace {

constexpr auto kSpeeds = std::to_array<std::pair<unsigned, speed_t>>({
    {9600U, B9600},
    {19200U, B19200},
    {38400U, B38400},
    {57600U, B57600},
    {115200U, B115200},
    {230400U, B230400},
    {460800U, B460800},
    {500000U, B500000},
    {921600U, B921600},
    {1000000U, B1000000},
    {1500000U, B1500000},
    {2000000U, B2000000},
    {3000000U, B3000000},
    {4000000U, B4000000},
});

speed_t speed_of(unsigned baud) {
    const auto* const found =
        std::find_if(kSpeeds.begin(), kSpeeds.end(), [baud](const auto& row) { return row.first == baud; });
    if (found == kSpeeds.end()) {
        throw std::invalid_argument(std::to_string(baud) + " baud: no speed of a serial line; use a standard one");
    }
    return found->second;
}

class Serial final : public Port {
public:
    Serial(const std::string& device, unsigned baud)
        : name_(device), file_(::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
        if (file_ < 0) {
            throw std::system_error(errno, std::generic_category(), "open the serial line " + device);
        }
        try {
            make_raw(baud);
        } catch (...) {
            ::close(file_);
            throw;
        }
    }
    Serial(const Serial&) = delete;
    Serial& operator=(const Serial&) = delete;
    ~Serial() override { ::close(file_); }

    [[nodiscard]] std::string name() const override { return name_; }
    [[nodiscard]] int file() const override { return file_; }
    std::size_t receive(std::span<std::uint8_t> out) override {
        const ssize_t n = ::read(file_, out.data(), out.size());
        return n > 0 ? static_cast<std::size_t>(n) : 0;
    }
    std::size_t send(std::span<const std::uint8_t> bytes) override {
        const ssize_t n = ::write(file_, bytes.data(), bytes.size());
        return n > 0 ? static_cast<std::size_t>(n) : 0;
    }

private:
    void make_raw(unsigned baud) const {
        termios settings{};
        if (::tcgetattr(file_, &settings) != 0) {
            throw std::invalid_argument(name_ + " is no serial line");
        }
        ::cfmakeraw(&settings);
        settings.c_cflag |= static_cast<tcflag_t>(CLOCAL | CREAD);
        settings.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS | CSTOPB);
        settings.c_cc[VMIN] = 0;
        settings.c_cc[VTIME] = 0;
        if (baud != 0) {
            ::cfsetispeed(&settings, speed_of(baud));
            ::cfsetospeed(&settings, speed_of(baud));
        }
        if (::tcsetattr(file_, TCSANOW, &settings) != 0) {
            throw std::system_error(errno, std::generic_category(), "set up the serial line " + name_);
        }
        ::tcflush(file_, TCIOFLUSH);
    }

    std::string name_;
    int file_;
};

}  // namespace

std::unique_ptr<Port> open_serial(const std::string& device, unsigned baud) {
    return std::make_unique<Serial>(device, baud);
}

}  // namespace sc::port
