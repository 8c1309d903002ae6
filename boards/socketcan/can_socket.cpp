// SPDX-License-Identifier: Apache-2.0
#include "boards/socketcan/can_socket.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <system_error>
#include <utility>

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

namespace sc::socketcan {
namespace {

[[noreturn]] void fail(int file, int error, const std::string& what) {
    if (file >= 0) {
        ::close(file);
    }
    throw std::system_error(error, std::generic_category(), what);
}

ifreq request_for(int file, const std::string& interface) {
    ifreq request{};
    if (interface.empty() || interface.size() >= sizeof request.ifr_name) {
        fail(file, EINVAL, "CAN interface '" + interface + "'");
    }
    std::copy(interface.begin(), interface.end(), std::begin(request.ifr_name));
    return request;
}

void allow_fd(int file, const std::string& interface) {
    ifreq request = request_for(file, interface);
    if (::ioctl(file, SIOCGIFMTU, &request) < 0) {
        fail(file, errno, "CAN interface " + interface + ": read its MTU");
    }
    const int yes = 1;
    if (request.ifr_mtu < static_cast<int>(CANFD_MTU)) {
        fail(file, EOPNOTSUPP, "CAN interface " + interface + " carries classic frames only (its MTU is not 72): FD");
    }
    if (::setsockopt(file, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &yes, sizeof yes) < 0) {
        fail(file, errno, "CAN interface " + interface + ": FD frames");
    }
}

void set_filters(int file, const CanOptions& options) {
    std::vector<can_filter> filters;
    for (const CanFilter& filter : options.filters) {
        filters.push_back({filter.id, (filter.mask & CAN_SFF_MASK) | CAN_EFF_FLAG | CAN_RTR_FLAG});
    }
    if (!filters.empty() && ::setsockopt(file, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                                         static_cast<socklen_t>(filters.size() * sizeof(can_filter))) < 0) {
        fail(file, errno, "CAN filters");
    }
    const can_err_mask_t all = CAN_ERR_MASK;
    if (::setsockopt(file, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &all, sizeof all) < 0) {
        fail(file, errno, "CAN error frames");
    }
}

int open_interface(const std::string& interface, const CanOptions& options) {
    const int file = ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if (file < 0) {
        fail(file, errno, "CAN interface " + interface + ": this kernel has no SocketCAN (modprobe can_raw)");
    }
    ifreq request = request_for(file, interface);
    if (::ioctl(file, SIOCGIFINDEX, &request) < 0) {
        fail(file, errno, "CAN interface " + interface + " ('ip -br link' lists what there is)");
    }
    const int index = request.ifr_ifindex;
    if (options.fd) {
        allow_fd(file, interface);
    }
    set_filters(file, options);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = index;
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the socket interface wants it.
    if (::bind(file, reinterpret_cast<const sockaddr*>(&address), sizeof address) < 0) {
        fail(file, errno, "CAN interface " + interface + ": bind (is it a CAN interface?)");
    }
    return file;
}

/// Best effort: without them frames are stamped when they are read, and drops stay unseen.
void ask_for_stamps(int file) {
    const int yes = 1;
    (void)::setsockopt(file, SOL_SOCKET, SO_TIMESTAMPNS, &yes, sizeof yes);
    (void)::setsockopt(file, SOL_SOCKET, SO_RXQ_OVFL, &yes, sizeof yes);
}

std::int64_t to_ns(const timespec& t) { return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec; }

std::int64_t now_ns() {
    timespec t{};
    ::clock_gettime(CLOCK_REALTIME, &t);
    return to_ns(t);
}

struct Packet {
    canfd_frame frame{};
    alignas(cmsghdr) std::array<std::uint8_t, 128> control{};
};

}  // namespace

CanSocket::CanSocket(const std::string& interface, const CanOptions& options)
    : file_(open_interface(interface, options)) {
    ask_for_stamps(file_);
}

CanSocket::CanSocket(int file, const CanOptions& /*options*/) : file_(file), paired_(true) { ask_for_stamps(file_); }

CanSocket::CanSocket(CanSocket&& other) noexcept
    : file_(std::exchange(other.file_, -1)),
      paired_(other.paired_),
      closed_(other.closed_),
      state_(other.state_),
      counters_(other.counters_) {}

CanSocket& CanSocket::operator=(CanSocket&& other) noexcept {
    if (this != &other) {
        close();
        file_ = std::exchange(other.file_, -1);
        paired_ = other.paired_;
        closed_ = other.closed_;
        state_ = other.state_;
        counters_ = other.counters_;
    }
    return *this;
}

CanSocket::~CanSocket() { close(); }

void CanSocket::close() noexcept {
    if (file_ >= 0) {
        ::close(file_);
        file_ = -1;
    }
}

CanSent CanSocket::refused(int error) noexcept {
    switch (error) {
        case ENOBUFS:
        case EAGAIN:
        case EINTR: ++counters_.full; return CanSent::full;
        case ENETDOWN:
        case ENODEV:
        case ENXIO:
            state_ = BusState::down;
            ++counters_.down;
            return CanSent::down;
        case EPIPE:
        case ECONNRESET:
            closed_ = true;
            ++counters_.down;
            return CanSent::down;
        default: ++counters_.failed; return CanSent::failed;
    }
}

CanSent CanSocket::send(const CanFrame& frame) noexcept {
    if (frame.fd ? !is_fd_size(frame.size) || frame.remote : frame.size > kClassicBytes) {
        ++counters_.failed;
        return CanSent::failed;
    }
    canfd_frame raw{};  // begins as struct can_frame does
    raw.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U) | (frame.remote ? CAN_RTR_FLAG : 0U);
    raw.len = frame.size;
    raw.flags = frame.fd && frame.fast ? CANFD_BRS : 0;
    std::copy_n(frame.data.begin(), frame.size, std::begin(raw.data));
    if (::send(file_, &raw, frame.fd ? CANFD_MTU : CAN_MTU, MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
        return refused(errno);
    }
    if (state_ == BusState::down) {
        state_ = BusState::active;
    }
    ++counters_.sent;
    return CanSent::yes;
}

bool CanSocket::receive(CanFrame& out) noexcept {
    while (file_ >= 0) {
        Packet packet;
        iovec part{&packet.frame, sizeof packet.frame};
        msghdr message{};
        message.msg_iov = &part;
        message.msg_iovlen = 1;
        message.msg_control = packet.control.data();
        message.msg_controllen = packet.control.size();
        const ssize_t size = ::recvmsg(file_, &message, MSG_DONTWAIT);
        if (size < 0) {
            if (errno == ENETDOWN || errno == ENODEV || errno == ENXIO || errno == ECONNRESET) {
                (void)refused(errno);
            }
            return false;
        }
        if (size == 0 && paired_) {
            closed_ = true;
            return false;
        }
        if (size != CAN_MTU && size != CANFD_MTU) {
            ++counters_.malformed;
            continue;
        }
        std::int64_t stamp = 0;
        for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
            if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_TIMESTAMPNS) {
                timespec t{};
                std::memcpy(&t, CMSG_DATA(c), sizeof t);
                stamp = to_ns(t);
            } else if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SO_RXQ_OVFL) {
                std::uint32_t total = 0;
                std::memcpy(&total, CMSG_DATA(c), sizeof total);
                counters_.dropped = total;
            }
        }
        const canfd_frame& raw = packet.frame;
        const bool fd = size == CANFD_MTU;
        if ((raw.can_id & CAN_ERR_FLAG) != 0) {
            std::array<std::uint8_t, kClassicBytes> data{};
            std::copy_n(std::begin(raw.data), data.size(), data.begin());
            note_error(raw.can_id & CAN_ERR_MASK, data);
            continue;
        }
        if (fd ? !is_fd_size(raw.len) : raw.len > kClassicBytes) {
            ++counters_.malformed;
            continue;
        }
        out.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
        out.id = raw.can_id & (out.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
        out.remote = !fd && (raw.can_id & CAN_RTR_FLAG) != 0;
        out.fd = fd;
        out.fast = fd && (raw.flags & CANFD_BRS) != 0;
        out.size = raw.len;
        out.data = {};
        std::copy_n(std::begin(raw.data), raw.len, out.data.begin());
        out.time_ns = stamp != 0 ? stamp : now_ns();
        // Whatever is heard has passed a bus that is neither down nor off.
        if (state_ == BusState::down || state_ == BusState::bus_off) {
            state_ = BusState::active;
        }
        ++counters_.received;
        return true;
    }
    return false;
}

/// Error frames: linux/can/error.h.
void CanSocket::note_error(std::uint32_t id, std::span<const std::uint8_t, kClassicBytes> data) noexcept {
    ++counters_.errors;
    if ((id & CAN_ERR_ACK) != 0) {
        ++counters_.no_acks;
    }
    if ((id & CAN_ERR_LOSTARB) != 0) {
        ++counters_.lost_arbitrations;
    }
    if ((id & CAN_ERR_CRTL) != 0) {
        const std::uint8_t detail = data[1];
        if ((detail & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) != 0) {
            ++counters_.overflows;
        }
        if ((detail & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) {
            state_ = BusState::passive;
        } else if ((detail & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0) {
            state_ = BusState::warning;
        } else if ((detail & CAN_ERR_CRTL_ACTIVE) != 0) {
            state_ = BusState::active;
        }
        counters_.tx_error_count = data[6];
        counters_.rx_error_count = data[7];
    }
    if ((id & CAN_ERR_RESTARTED) != 0) {
        ++counters_.restarts;
        state_ = BusState::active;
    }
    if ((id & CAN_ERR_BUSOFF) != 0) {
        ++counters_.bus_offs;
        state_ = BusState::bus_off;
    }
}

bool is_fd_size(std::size_t size) noexcept {
    constexpr std::array<std::size_t, 7> kLong{12, 16, 20, 24, 32, 48, 64};
    return size <= kClassicBytes || std::find(kLong.begin(), kLong.end(), size) != kLong.end();
}

}  // namespace sc::socketcan
