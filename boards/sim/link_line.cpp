// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/link_line.hpp"

#include <algorithm>
#include <array>

#include "boards/sim/carrier/can_bus.hpp"
#include "boards/sim/plant/serial_wire.hpp"
#include "firmware/hal/io.hpp"
#include "shared/link/can_port.hpp"
#include "shared/link/can_record.hpp"

namespace sc::sim {
namespace {

class SerialLine final : public LinkLine {
public:
    SerialLine(std::uint32_t baud, std::int64_t tick_ns)
        : to_controller_(baud, tick_ns, kLinkBytesPerTick), to_host_(baud, tick_ns, kLinkBytesPerTick) {}

    void push_host(std::span<const std::uint8_t> bytes) override { to_controller_.push(bytes); }
    void push_controller(std::span<const std::uint8_t> bytes) override { to_host_.push(bytes); }
    void tick(std::vector<std::uint8_t>& to_controller, std::vector<std::uint8_t>& to_host) override {
        to_controller_.tick(to_controller);
        to_host_.tick(to_host);
    }
    void set_connected(bool connected) override {
        to_controller_.set_connected(connected);
        to_host_.set_connected(connected);
    }

private:
    SerialWire to_controller_;
    SerialWire to_host_;
};

class CanLine final : public LinkLine {
public:
    CanLine(bool fd, std::int64_t tick_ns) : fd_(fd), tick_ns_(tick_ns), bus_({}, {}), port_(link::kCanIdToHost, fd) {}

    void push_host(std::span<const std::uint8_t> bytes) override {
        begun_.insert(begun_.end(), bytes.begin(), bytes.end());
        const std::size_t size = link::can_record_size(fd_);
        std::size_t at = 0;
        for (; begun_.size() - at >= size; at += size) {
            const auto frame = link::get_can_record(std::span(begun_).subspan(at, size), fd_);
            if (frame && connected_) {
                bus_.send(kHost, *frame, now_ns_);
            }
        }
        begun_.erase(begun_.begin(), begun_.begin() + static_cast<std::ptrdiff_t>(at));
    }
    void push_controller(std::span<const std::uint8_t> bytes) override {
        while (!bytes.empty()) {
            bytes = bytes.subspan(port_.push(bytes));
            link::LinkCanFrame frame;
            while (port_.next(frame)) {
                if (connected_) {
                    bus_.send(kController, frame, now_ns_);
                }
            }
        }
    }
    void tick(std::vector<std::uint8_t>& to_controller, std::vector<std::uint8_t>& to_host) override {
        now_ns_ += tick_ns_;
        frames_.clear();
        bus_.receive(kController, now_ns_, frames_);
        std::array<std::uint8_t, link::kSerialCapacity> message{};
        for (const link::LinkCanFrame& frame : frames_) {
            const std::size_t n = frame.id == link::kCanIdToController ? port_.take(frame, message) : 0;
            arrived_.insert(arrived_.end(), message.begin(), message.begin() + static_cast<std::ptrdiff_t>(n));
        }
        const std::size_t n = std::min(arrived_.size(), kLinkBytesPerTick);
        const auto end = arrived_.begin() + static_cast<std::ptrdiff_t>(n);
        to_controller.insert(to_controller.end(), arrived_.begin(), end);
        arrived_.erase(arrived_.begin(), end);

        frames_.clear();
        bus_.receive(kHost, now_ns_, frames_);
        for (const link::LinkCanFrame& frame : frames_) {
            const std::size_t at = to_host.size();
            to_host.resize(at + link::can_record_size(fd_));
            link::put_can_record(frame, std::span(to_host).subspan(at));
        }
    }
    void set_connected(bool connected) override {
        if (connected_ && !connected) {
            bus_.reset(kHost);
            bus_.reset(kController);
            arrived_.clear();
        }
        connected_ = connected;
    }

private:
    static constexpr std::size_t kHost = 0;
    static constexpr std::size_t kController = 1;

    bool fd_;
    bool connected_ = true;
    std::int64_t tick_ns_;
    std::int64_t now_ns_ = 0;
    CanBus bus_;
    link::CanPort<2 * kLinkBytesPerTick> port_;
    std::vector<std::uint8_t> begun_;    ///< of a record
    std::vector<std::uint8_t> arrived_;  ///< for the controller, not yet taken
    std::vector<link::LinkCanFrame> frames_;
};

}  // namespace

std::unique_ptr<LinkLine> make_link_line(LinkCarrier carrier, std::uint32_t baud, std::int64_t tick_ns) {
    if (carrier == LinkCarrier::serial) {
        return std::make_unique<SerialLine>(baud, tick_ns);
    }
    return std::make_unique<CanLine>(carrier == LinkCarrier::canfd, tick_ns);
}

}  // namespace sc::sim
