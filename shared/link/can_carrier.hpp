// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/link/can_port.hpp"

namespace sc::link {

/// The controller's end of a CAN link on a port of the board: messages as frames, both ways. A frame that the port has
/// no room for waits; messages behind it too, until their room is full as well. `Port`: has a type `Frame`,
/// `bool receive(Frame&)` and `send(const Frame&)`, whose result has a value `full`. No heap; nothing blocks.
template <class Port, std::size_t Capacity>
class CanCarrier {
public:
    CanCarrier(Port& port, bool fd) noexcept : port_(&port), fd_(fd), ends_(kCanIdToHost, fd) {}

    /// Whole messages that have come, as many as fit; what more there is waits.
    [[nodiscard]] std::size_t receive(std::span<std::uint8_t> out) noexcept {
        std::size_t size = 0;
        typename Port::Frame heard;
        while (message_size_ <= out.size() - size) {
            std::copy_n(message_.begin(), message_size_, out.begin() + static_cast<std::ptrdiff_t>(size));
            size += message_size_;
            message_size_ = 0;
            if (!port_->receive(heard)) {
                break;
            }
            if (heard.id != kCanIdToController || heard.extended || heard.remote) {
                continue;
            }
            const LinkCanFrame frame{.id = heard.id, .size = heard.size, .data = heard.data, .fd = heard.fd};
            message_size_ = ends_.take(frame, message_);
        }
        return size;
    }

    /// Sends what waits, and then these; how many bytes found room.
    std::size_t send(std::span<const std::uint8_t> bytes) noexcept {
        flush();
        const std::size_t taken = ends_.push(bytes);
        flush();
        return taken;
    }

private:
    void flush() noexcept {
        while (has_waiting_ || ends_.next(waiting_)) {
            typename Port::Frame frame;
            frame.id = waiting_.id;
            frame.fd = frame.fast = fd_;
            frame.size = waiting_.size;
            frame.data = waiting_.data;
            const auto sent = port_->send(frame);
            has_waiting_ = sent == decltype(sent)::full;
            // On a bus that is down nothing waits: what was said would be old when it is back.
            if (has_waiting_) {
                return;
            }
        }
    }

    Port* port_;
    bool fd_;
    CanPort<Capacity> ends_;
    LinkCanFrame waiting_;
    bool has_waiting_ = false;
    std::array<std::uint8_t, kSerialCapacity> message_{};
    std::size_t message_size_ = 0;  ///< of a message that did not fit into the last tick
};

}  // namespace sc::link
