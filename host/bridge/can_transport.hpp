// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "host/bridge/transport.hpp"
#include "host/formats/capture_file.hpp"
#include "shared/link/can_port.hpp"

namespace sc::host {

/// The link over CAN: messages cut into frames and put together again, over a carrier of frames as records
/// (shared/link/can_record.hpp): a simulated cell or a raw CAN socket.
class CanTransport final : public Transport {
public:
    /// `capture`: where each frame is noted; none without one.
    /// `offset`: from the carrier's time to that of the file.
    CanTransport(std::unique_ptr<Transport> records, bool fd, std::unique_ptr<CaptureWriter> capture,
                 Nanoseconds offset = Nanoseconds::zero());
    ~CanTransport() override;

    void send(std::span<const std::uint8_t> bytes) override;
    std::size_t receive(std::span<std::uint8_t> out, HostTime until) override;
    [[nodiscard]] HostTime now() const override { return records_->now(); }
    [[nodiscard]] bool closed() const override { return records_->closed(); }

private:
    using Port = link::CanPort<4096>;

    void take(std::span<const std::uint8_t> bytes);
    void note(const link::LinkCanFrame& frame);
    [[nodiscard]] std::size_t hand_over(std::span<std::uint8_t> out);

    std::unique_ptr<Transport> records_;
    bool fd_;
    Nanoseconds offset_;
    std::unique_ptr<CaptureWriter> capture_;
    Port port_;
    std::vector<std::uint8_t> begun_;    ///< of a record
    std::vector<std::uint8_t> arrived_;  ///< messages, as the client takes them
    std::size_t handed_over_ = 0;
};

}  // namespace sc::host
