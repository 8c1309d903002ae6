// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/socket_can_transport.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include "host/formats/error.hpp"
#include "shared/link/can_port.hpp"
#include "shared/link/can_record.hpp"

namespace sc::host {
namespace {

/// Some seconds of a full bus: nobody takes them.
constexpr std::size_t kWaitingLimit = 20'000;
/// poll does not tell when an interface's queue has room again.
constexpr Nanoseconds kRetry{500'000};

HostTime monotonic_now() {
    const auto since = std::chrono::steady_clock::now().time_since_epoch();
    return HostTime{std::chrono::duration_cast<Nanoseconds>(since)};
}

[[noreturn]] void refuse(const std::string& interface, const std::string& problem, const std::string& action) {
    throw InputError({.file = {}, .problem = problem, .value = interface, .action = action});
}

ifreq request_for(const std::string& interface) {
    ifreq request{};
    if (interface.size() >= sizeof request.ifr_name) {
        refuse(interface, "no name of a CAN interface", "`scribecell ports` lists what there is");
    }
    std::copy(interface.begin(), interface.end(), std::begin(request.ifr_name));
    return request;
}

void set_up(int socket, const std::string& interface, bool fd) {
    const int yes = 1;
    if (fd) {
        ifreq request = request_for(interface);
        if (::ioctl(socket, SIOCGIFMTU, &request) < 0 || request.ifr_mtu < static_cast<int>(CANFD_MTU) ||
            ::setsockopt(socket, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &yes, sizeof yes) < 0) {
            refuse(interface, "this CAN interface carries classic frames only",
                   "leave ?fd=1 out, or set it up with FD: ip link set " + interface +
                       " up type can bitrate 1000000 dbitrate 5000000 fd on");
        }
    }
    const can_filter filter{link::kCanIdToHost, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG};
    const can_err_mask_t errors = CAN_ERR_MASK;
    (void)::setsockopt(socket, SOL_CAN_RAW, CAN_RAW_FILTER, &filter, sizeof filter);
    (void)::setsockopt(socket, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors);
}

}  // namespace

SocketCanTransport::SocketCanTransport(UniqueFd socket, bool fd) : socket_(std::move(socket)), fd_(fd) {}

HostTime SocketCanTransport::now() const { return monotonic_now(); }

void SocketCanTransport::note_trouble(int error) {
    if (error == ENETDOWN) {
        ++counters_.down;
    } else if (error != EAGAIN && error != EINTR) {
        closed_ = true;
    }
}

void SocketCanTransport::send(std::span<const std::uint8_t> records) {
    begun_.insert(begun_.end(), records.begin(), records.end());
    const std::size_t size = link::can_record_size(fd_);
    std::size_t at = 0;
    for (; begun_.size() - at >= size; at += size) {
        const auto frame = link::get_can_record(std::span(begun_).subspan(at, size), fd_);
        if (!frame) {
            continue;
        }
        canfd_frame raw{};
        raw.can_id = frame->id;
        raw.len = frame->size;
        raw.flags = fd_ ? CANFD_BRS : 0;
        std::copy_n(frame->data.begin(), frame->size, std::begin(raw.data));
        std::vector<std::uint8_t> bytes(fd_ ? CANFD_MTU : CAN_MTU);
        std::memcpy(bytes.data(), &raw, bytes.size());
        waiting_.push_back(std::move(bytes));
    }
    begun_.erase(begun_.begin(), begun_.begin() + static_cast<std::ptrdiff_t>(at));
    flush();
    closed_ = closed_ || waiting_.size() > kWaitingLimit;
}

void SocketCanTransport::flush() {
    while (!waiting_.empty() && !closed_) {
        const std::vector<std::uint8_t>& frame = waiting_.front();
        if (::send(socket_.get(), frame.data(), frame.size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
            if (errno == ENOBUFS || errno == EAGAIN || errno == EINTR) {
                ++counters_.full;
                return;
            }
            note_trouble(errno);
        }
        waiting_.pop_front();
    }
}

/// False when nothing waits.
bool SocketCanTransport::take_one(std::vector<std::uint8_t>& record) {
    record.clear();
    canfd_frame raw{};
    const ssize_t n = ::recv(socket_.get(), &raw, sizeof raw, MSG_DONTWAIT);
    if (n <= 0) {
        note_trouble(n == 0 ? ENODEV : errno);
        return false;
    }
    if ((raw.can_id & CAN_ERR_FLAG) != 0) {
        ++counters_.errors;
        counters_.bus_offs += (raw.can_id & CAN_ERR_BUSOFF) != 0 ? 1 : 0;
        counters_.restarts += (raw.can_id & CAN_ERR_RESTARTED) != 0 ? 1 : 0;
        return true;
    }
    const bool fd = n == CANFD_MTU;
    if ((!fd && n != CAN_MTU) || raw.len > (fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN)) {
        ++counters_.malformed;
        return true;
    }
    if (fd != fd_ || (raw.can_id & (CAN_EFF_FLAG | CAN_RTR_FLAG)) != 0) {
        return true;  // another's
    }
    link::LinkCanFrame frame;
    frame.id = raw.can_id & CAN_SFF_MASK;
    frame.size = raw.len;
    frame.fd = fd;
    std::copy_n(std::begin(raw.data), raw.len, frame.data.begin());
    record.resize(link::can_record_size(fd_));
    link::put_can_record(frame, record);
    return true;
}

std::size_t SocketCanTransport::receive(std::span<std::uint8_t> out, HostTime until) {
    const std::size_t size = link::can_record_size(fd_);
    std::vector<std::uint8_t> record;
    while (!closed_) {
        flush();
        std::size_t got = 0;
        while (out.size() - got >= size && take_one(record)) {
            std::copy(record.begin(), record.end(), out.begin() + static_cast<std::ptrdiff_t>(got));
            got += record.size();
        }
        const Nanoseconds left = until - monotonic_now();
        if (got > 0 || closed_ || left <= Nanoseconds::zero()) {
            return got;
        }
        const Nanoseconds most = waiting_.empty() ? left : std::min(left, kRetry);
        const timespec timeout{static_cast<time_t>(most.count() / 1'000'000'000),
                               static_cast<long>(most.count() % 1'000'000'000)};
        pollfd wait{socket_.get(), POLLIN, 0};
        if (::ppoll(&wait, 1, &timeout, nullptr) < 0 && errno == EINTR) {
            return 0;
        }
    }
    return 0;
}

std::unique_ptr<Transport> open_socket_can(const std::string& interface, bool fd) {
    UniqueFd socket(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
    if (!socket.valid()) {
        refuse(interface, "this kernel has no SocketCAN", "modprobe can_raw, or start a kernel that has it");
    }
    ifreq request = request_for(interface);
    if (::ioctl(socket.get(), SIOCGIFINDEX, &request) < 0) {
        refuse(interface, "there is no such CAN interface", "`scribecell ports` lists what there is");
    }
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = request.ifr_ifindex;
    set_up(socket.get(), interface, fd);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the socket interface wants it.
    if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) < 0) {
        refuse(interface, "is no CAN interface", "`scribecell ports` lists what there is");
    }
    return std::make_unique<SocketCanTransport>(std::move(socket), fd);
}

}  // namespace sc::host
