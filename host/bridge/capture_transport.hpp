// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>

#include "host/bridge/transport.hpp"
#include "host/formats/capture_file.hpp"

namespace sc::host {

/// A carrier of bytes, and a capture file of all that passes.
class CaptureTransport final : public Transport {
public:
    /// `offset`: from the carrier's time to that of the file.
    CaptureTransport(std::unique_ptr<Transport> carrier, std::unique_ptr<CaptureWriter> capture, Nanoseconds offset)
        : carrier_(std::move(carrier)), capture_(std::move(capture)), offset_(offset) {}
    ~CaptureTransport() override;

    void send(std::span<const std::uint8_t> bytes) override;
    std::size_t receive(std::span<std::uint8_t> out, HostTime until) override;
    [[nodiscard]] HostTime now() const override { return carrier_->now(); }
    [[nodiscard]] bool closed() const override { return carrier_->closed(); }

private:
    [[nodiscard]] std::int64_t file_time() const { return (now().time_since_epoch() + offset_).count(); }

    std::unique_ptr<Transport> carrier_;
    std::unique_ptr<CaptureWriter> capture_;
    Nanoseconds offset_;
};

/// Closes it, and says on stderr if it is not whole. Null: nothing.
void close_capture(CaptureWriter* capture);

}  // namespace sc::host
