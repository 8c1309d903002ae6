// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <termios.h>

#include "host/bridge/fd_transport.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
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
        throw InputError({.file = {},
                          .problem = "no speed of a serial line",
                          .value = std::to_string(baud),
                          .action = "use a standard one, such as 115200, 921600 or 3000000"});
    }
    return found->second;
}

void make_raw(int fd, const std::filesystem::path& device, unsigned baud) {
    termios settings{};
    if (::tcgetattr(fd, &settings) != 0) {
        throw InputError({.file = device.string(),
                          .problem = "no serial line",
                          .value = {},
                          .action = "name a serial device, such as /dev/ttyUSB0"});
    }
    ::cfmakeraw(&settings);
    settings.c_cflag |= static_cast<tcflag_t>(CLOCAL | CREAD);
    settings.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS | CSTOPB);
    settings.c_cc[VMIN] = 1;
    settings.c_cc[VTIME] = 0;
    if (baud != 0) {
        ::cfsetispeed(&settings, speed_of(baud));
        ::cfsetospeed(&settings, speed_of(baud));
    }
    ::tcsetattr(fd, TCSANOW, &settings);
    ::tcflush(fd, TCIOFLUSH);
}

}  // namespace

std::unique_ptr<Transport> open_serial(const std::filesystem::path& device, unsigned baud) {
    UniqueFd fd(::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    if (!fd.valid()) {
        throw InputError({.file = device.string(),
                          .problem = std::string("cannot be opened: ") + std::strerror(errno),
                          .value = {},
                          .action = "check the name, the cable and your rights (group dialout)"});
    }
    make_raw(fd.get(), device, baud);
    return std::make_unique<FdTransport>(std::move(fd));
}

}  // namespace sc::host
