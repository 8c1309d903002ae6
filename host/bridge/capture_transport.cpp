// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/capture_transport.hpp"

#include <cstdio>

namespace sc::host {

void close_capture(CaptureWriter* capture) {
    if (capture == nullptr) {
        return;
    }
    capture->close();
    if (!capture->error().empty()) {
        std::fprintf(stderr, "scribecell: the capture ended early, the link went on: %s\n", capture->error().c_str());
    }
}

CaptureTransport::~CaptureTransport() { close_capture(capture_.get()); }

void CaptureTransport::send(std::span<const std::uint8_t> bytes) {
    capture_->serial(true, bytes, file_time());
    carrier_->send(bytes);
}

std::size_t CaptureTransport::receive(std::span<std::uint8_t> out, HostTime until) {
    const std::size_t n = carrier_->receive(out, until);
    capture_->serial(false, out.first(n), file_time());
    return n;
}

}  // namespace sc::host
