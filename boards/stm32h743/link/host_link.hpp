// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "boards/stm32h743/link/fdcan.hpp"
#include "boards/stm32h743/link/host_uart.hpp"
#include "firmware/hal/io.hpp"
#include "shared/link/can_carrier.hpp"

namespace sc::stm32h743 {

/// Where the host plugs in. Once a tick each way.
class HostLink {
public:
    HostLink() = default;
    HostLink(const HostLink&) = delete;
    HostLink& operator=(const HostLink&) = delete;
    /// What has come since the last tick; what more there is waits.
    [[nodiscard]] virtual std::size_t receive(std::span<std::uint8_t, kLinkBytesPerTick> out) noexcept = 0;
    virtual void send(std::span<const std::uint8_t> bytes) noexcept = 0;
    /// Once a tick, before the others.
    virtual void service(std::int64_t now_ns) noexcept = 0;
    /// Bytes for the host that nobody took. Monotonic.
    [[nodiscard]] virtual std::uint32_t lost() const noexcept = 0;

protected:
    ~HostLink() = default;
};

/// Over CAN.
class HostCan final : public HostLink {
public:
    /// `fd`: the host is spoken to in FD frames with rate switch; both kinds are understood.
    HostCan(Fdcan& port, bool fd) noexcept : port_(port), carrier_(port, fd) {}
    [[nodiscard]] std::size_t receive(std::span<std::uint8_t, kLinkBytesPerTick> out) noexcept override {
        return carrier_.receive(out);
    }
    void send(std::span<const std::uint8_t> bytes) noexcept override {
        lost_ += static_cast<std::uint32_t>(bytes.size() - carrier_.send(bytes));
    }
    void service(std::int64_t now_ns) noexcept override { port_.service(now_ns); }
    [[nodiscard]] std::uint32_t lost() const noexcept override { return lost_; }

private:
    Fdcan& port_;
    link::CanCarrier<Fdcan, 8 * kLinkBytesPerTick> carrier_;
    std::uint32_t lost_ = 0;
};

/// Over the serial port; then both FDCANs are free for drives.
class HostSerial final : public HostLink {
public:
    explicit HostSerial(HostUart& port) noexcept : port_(port) {}
    [[nodiscard]] std::size_t receive(std::span<std::uint8_t, kLinkBytesPerTick> out) noexcept override {
        return port_.receive(out);
    }
    void send(std::span<const std::uint8_t> bytes) noexcept override { port_.send(bytes); }
    void service(std::int64_t /*now_ns*/) noexcept override {}
    [[nodiscard]] std::uint32_t lost() const noexcept override { return port_.counters().unsent; }

private:
    HostUart& port_;
};

}  // namespace sc::stm32h743
