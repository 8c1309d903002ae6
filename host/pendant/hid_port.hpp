// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "host/pendant/port.hpp"

namespace sc::host::pendant {

/// A pendant on USB, by hidapi. It may be plugged in later, be unplugged and come back. Reads and writes have threads
/// of their own: a read that fails is the only sign of an unplugged device, and a write may hang.
class HidPort final : public PendantPort {
public:
    /// `device`: a file as /dev/hidraw3; empty: the first device with the pendant's numbers.
    explicit HidPort(std::string device = {});
    ~HidPort() override;
    [[nodiscard]] std::optional<PortEvent> next(HostTime now) override;
    void show(const Display& display) override;
    [[nodiscard]] bool ended() const override { return false; }
    [[nodiscard]] bool real() const override { return true; }
    /// Why it cannot be opened although it is there; empty without a problem.
    [[nodiscard]] std::string problem() const;

private:
    struct Shared;
    std::unique_ptr<Shared> shared_;
};

}  // namespace sc::host::pendant
