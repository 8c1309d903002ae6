// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/link/drive_ports.hpp"

#include <algorithm>

namespace sc::stm32h743 {

std::span<const DriveFrame> DrivePorts::receive() noexcept {
    std::size_t count = 0;
    for (std::size_t bus = 0; bus < ports_.size(); ++bus) {
        CanFrame heard;
        while (ports_[bus] != nullptr && count < heard_.size() && ports_[bus]->receive(heard)) {
            if (heard.extended || heard.remote || heard.fd) {
                ++counters_.foreign;
                continue;
            }
            DriveFrame& frame = heard_[count++];
            frame.id = static_cast<std::uint16_t>(heard.id | (bus == 0 ? 0U : kSecondDriveBus));
            frame.size = heard.size;
            std::copy_n(heard.data.begin(), frame.data.size(), frame.data.begin());
        }
    }
    return std::span<const DriveFrame>(heard_).first(count);
}

void DrivePorts::send(std::span<const DriveFrame> frames) noexcept {
    for (const DriveFrame& frame : frames) {
        Fdcan* port = ports_[(frame.id & kSecondDriveBus) != 0 ? 1 : 0];
        CanFrame raw;
        raw.id = frame.id & ~std::uint32_t{kSecondDriveBus};
        raw.size = frame.size;
        std::copy(frame.data.begin(), frame.data.end(), raw.data.begin());
        if (port == nullptr || port->send(raw) != CanSent::yes) {
            ++counters_.unsent;
        }
    }
}

void DrivePorts::service(std::int64_t now_ns) noexcept {
    for (Fdcan* port : ports_) {
        if (port != nullptr) {
            port->service(now_ns);
        }
    }
}

}  // namespace sc::stm32h743
