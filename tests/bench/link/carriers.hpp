// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "boards/sim/carrier/can_bus.hpp"
#include "boards/sim/carrier/serial_line.hpp"
#include "shared/link/can_port.hpp"

namespace sc::bench {

/// A mock carrier between two endpoints that speak COBS bytes. End 0 is the host, end 1 the controller.
class Carrier {
public:
    Carrier() = default;
    Carrier(const Carrier&) = delete;
    Carrier& operator=(const Carrier&) = delete;
    virtual ~Carrier() = default;
    virtual void send(std::size_t end, std::span<const std::uint8_t> bytes, std::int64_t now_ns) = 0;
    virtual void receive(std::size_t end, std::int64_t now_ns, std::vector<std::uint8_t>& out) = 0;
    virtual void reset(std::size_t end) = 0;
    /// Of one message as it would pass without trouble.
    [[nodiscard]] virtual std::int64_t message_ns(std::span<const std::uint8_t> cobs) const = 0;
    [[nodiscard]] virtual bool shared_by_both() const = 0;  ///< both directions take turns
};

class SerialCarrier final : public Carrier {
public:
    SerialCarrier(std::uint32_t baud, const sim::Troubles& troubles) : baud_(baud), line_(baud, troubles) {}
    void send(std::size_t end, std::span<const std::uint8_t> bytes, std::int64_t now_ns) override {
        line_.send(end, bytes, now_ns);
    }
    void receive(std::size_t end, std::int64_t now_ns, std::vector<std::uint8_t>& out) override {
        line_.receive(end, now_ns, out);
    }
    void reset(std::size_t end) override { line_.reset(end); }
    [[nodiscard]] std::int64_t message_ns(std::span<const std::uint8_t> cobs) const override {
        return static_cast<std::int64_t>(cobs.size()) * 10'000'000'000 / baud_;
    }
    [[nodiscard]] bool shared_by_both() const override { return false; }

private:
    std::uint32_t baud_;
    sim::SerialLine line_;
};

class CanCarrier final : public Carrier {
public:
    CanCarrier(bool fd, const sim::CanRates& rates, const sim::Troubles& troubles)
        : fd_(fd), rates_(rates), bus_(rates, troubles) {
        reset(0);
        reset(1);
    }
    void send(std::size_t end, std::span<const std::uint8_t> bytes, std::int64_t now_ns) override {
        while (!bytes.empty()) {
            bytes = bytes.subspan(ports_[end]->push(bytes));
            link::LinkCanFrame frame;
            while (ports_[end]->next(frame)) {
                bus_.send(end, frame, now_ns);
            }
        }
    }
    void receive(std::size_t end, std::int64_t now_ns, std::vector<std::uint8_t>& out) override {
        frames_.clear();
        bus_.receive(end, now_ns, frames_);
        std::array<std::uint8_t, link::kSerialCapacity> bytes{};
        for (const link::LinkCanFrame& frame : frames_) {
            const std::size_t size = ports_[end]->take(frame, bytes);
            out.insert(out.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
        }
    }
    void reset(std::size_t end) override {
        bus_.reset(end);
        ports_[end] = std::make_unique<Port>(end == 0 ? link::kCanIdToController : link::kCanIdToHost, fd_);
    }
    [[nodiscard]] std::int64_t message_ns(std::span<const std::uint8_t> cobs) const override {
        Port port(link::kCanIdToController, fd_);
        (void)port.push(cobs);
        std::int64_t time = 0;
        link::LinkCanFrame frame;
        while (port.next(frame)) {
            time += sim::frame_ns(frame, rates_);
        }
        return time;
    }
    [[nodiscard]] bool shared_by_both() const override { return true; }
    [[nodiscard]] const sim::CanBus& bus() const { return bus_; }

private:
    using Port = link::CanPort<4096>;
    bool fd_;
    sim::CanRates rates_;
    sim::CanBus bus_;
    std::array<std::unique_ptr<Port>, 2> ports_;
    std::vector<link::LinkCanFrame> frames_;
};

/// "classic_1m", "fd_1m_5m", "serial_921k", "serial_3m".
[[nodiscard]] inline std::unique_ptr<Carrier> make_carrier(const std::string& name, const sim::Troubles& troubles) {
    if (name == "classic_1m") {
        return std::make_unique<CanCarrier>(false, sim::CanRates{}, troubles);
    }
    if (name == "fd_1m_5m") {
        return std::make_unique<CanCarrier>(true, sim::CanRates{}, troubles);
    }
    return std::make_unique<SerialCarrier>(name == "serial_3m" ? 3'000'000U : 921'600U, troubles);
}

}  // namespace sc::bench
