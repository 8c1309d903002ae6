// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sc::linux_rt {

/// Words to the service manager: datagrams to the socket that NOTIFY_SOCKET names (sd_notify(3)). Without that variable
/// nothing is sent.
class ServiceNotify {
public:
    /// Reads NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID.
    ServiceNotify();
    ~ServiceNotify();
    ServiceNotify(const ServiceNotify&) = delete;
    ServiceNotify& operator=(const ServiceNotify&) = delete;

    /// Such as "READY=1", "STATUS=…", "WATCHDOG=1", "STOPPING=1". False if it was not sent.
    bool say(std::string_view words) const;
    /// How often the manager wants to hear of a live process: half of what it allows; nullopt: it does not watch.
    [[nodiscard]] std::optional<std::int64_t> watchdog_ns() const noexcept { return watchdog_ns_; }

private:
    std::string socket_;
    int file_ = -1;
    std::optional<std::int64_t> watchdog_ns_;
};

}  // namespace sc::linux_rt
