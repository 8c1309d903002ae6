// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/hal/io.hpp"

namespace sc::drives {

/// Whoever uses a drive's SDO channel while the master does not: reads its name, its history of errors. Called in the
/// control tick; must not block.
class SdoService {
public:
    /// Once a tick in which an SDO frame may be sent to this node.
    [[nodiscard]] virtual std::optional<DriveFrame> poll(std::uint8_t node, std::int64_t tick) noexcept = 0;
    /// An SDO answer of the node, without the bit of its bus.
    virtual void receive(const DriveFrame& frame) noexcept = 0;
    /// The node has booted again: what is under way is lost.
    virtual void restarted() noexcept = 0;

protected:
    ~SdoService() = default;
};

}  // namespace sc::drives
