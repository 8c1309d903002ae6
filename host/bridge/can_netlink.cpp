// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/can_netlink.hpp"

#include <array>
#include <cstring>
#include <vector>

#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>

#include "host/bridge/unique_fd.hpp"

namespace sc::host {
namespace {

constexpr unsigned kAttributeMask = 0x3FFF;  ///< without the flags for nested and network order

using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t aligned(std::size_t size) { return (size + 3) & ~std::size_t{3}; }

template <class T>
std::optional<T> value(Bytes bytes) {
    if (bytes.size() < sizeof(T)) {
        return std::nullopt;
    }
    T out{};
    std::memcpy(&out, bytes.data(), sizeof(T));
    return out;
}

/// Calls `take(type, payload)` for each attribute; stops at one that is not whole.
template <class Take>
void each_attribute(Bytes bytes, Take take) {
    while (const auto head = value<rtattr>(bytes)) {
        if (head->rta_len < sizeof(rtattr) || head->rta_len > bytes.size()) {
            return;
        }
        take(head->rta_type & kAttributeMask, bytes.subspan(sizeof(rtattr), head->rta_len - sizeof(rtattr)));
        const std::size_t next = aligned(head->rta_len);
        if (next >= bytes.size()) {
            return;
        }
        bytes = bytes.subspan(next);
    }
}

const char* name_of(std::uint32_t state) {
    constexpr std::array<const char*, 6> kNames{"error-active", "error-warning", "error-passive",
                                                "bus-off",      "stopped",       "sleeping"};
    return state < kNames.size() ? kNames.at(state) : "";
}

void take_data(CanDetails& out, unsigned type, Bytes payload) {
    const auto rate = [payload] {
        const auto timing = value<can_bittiming>(payload);
        return timing && timing->bitrate > 0 ? std::optional(timing->bitrate) : std::nullopt;
    };
    if (type == IFLA_CAN_BITTIMING) {
        out.bitrate = rate();
    } else if (type == IFLA_CAN_DATA_BITTIMING) {
        out.data_bitrate = rate();
    } else if (type == IFLA_CAN_STATE) {
        out.state = name_of(value<std::uint32_t>(payload).value_or(99));
    } else if (type == IFLA_CAN_RESTART_MS) {
        out.restart_ms = value<std::uint32_t>(payload).value_or(0);
    }
}

void take_info(CanDetails& out, unsigned type, Bytes payload) {
    if (type == IFLA_INFO_KIND) {
        const std::string text(payload.begin(), payload.end());
        out.kind = text.c_str();
    } else if (type == IFLA_INFO_DATA) {
        each_attribute(payload, [&out](unsigned inner, Bytes bytes) { take_data(out, inner, bytes); });
    }
}

}  // namespace

std::optional<CanDetails> parse_can_link(std::span<const std::uint8_t> message) {
    const auto head = value<nlmsghdr>(message);
    constexpr std::size_t kHead = sizeof(nlmsghdr) + sizeof(ifinfomsg);
    if (!head || head->nlmsg_type != RTM_NEWLINK || head->nlmsg_len < kHead || head->nlmsg_len > message.size()) {
        return std::nullopt;
    }
    CanDetails out;
    each_attribute(message.subspan(kHead, head->nlmsg_len - kHead), [&out](unsigned type, Bytes payload) {
        if (type == IFLA_TXQLEN) {
            out.queue_length = value<std::uint32_t>(payload).value_or(0);
        } else if (type == IFLA_LINKINFO) {
            each_attribute(payload, [&out](unsigned inner, Bytes bytes) { take_info(out, inner, bytes); });
        }
    });
    return out;
}

std::optional<CanDetails> ask_can_link(unsigned index) {
    const UniqueFd socket(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE));
    struct {
        nlmsghdr head{};
        ifinfomsg info{};
    } request;
    request.head.nlmsg_len = sizeof request;
    request.head.nlmsg_type = RTM_GETLINK;
    request.head.nlmsg_flags = NLM_F_REQUEST;
    request.info.ifi_family = AF_UNSPEC;
    request.info.ifi_index = static_cast<int>(index);
    const timeval patience{1, 0};
    (void)::setsockopt(socket.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (!socket.valid() || ::send(socket.get(), &request, sizeof request, 0) < 0) {
        return std::nullopt;
    }
    std::vector<std::uint8_t> answer(32'768);
    const ssize_t n = ::recv(socket.get(), answer.data(), answer.size(), 0);
    return n > 0 ? parse_can_link(std::span(answer).first(static_cast<std::size_t>(n))) : std::nullopt;
}

}  // namespace sc::host
