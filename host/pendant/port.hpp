// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "host/pendant/whb04b.hpp"
#include "shared/units/time.hpp"

namespace sc::host::pendant {

struct PortEvent {
    enum class Kind : std::uint8_t { report, plugged, unplugged };
    Kind kind = Kind::report;
    std::array<std::uint8_t, 64> bytes{};  ///< of a report, as they came
    std::size_t size = 0;
    Nanoseconds age{0};  ///< since it was read
};

/// A pendant, or what plays one.
class PendantPort {
public:
    PendantPort() = default;
    PendantPort(const PendantPort&) = delete;
    PendantPort& operator=(const PendantPort&) = delete;
    virtual ~PendantPort() = default;

    /// What has come, in order; without waiting. `now` is the clock that the cell is served by.
    [[nodiscard]] virtual std::optional<PortEvent> next(HostTime now) = 0;
    /// Never blocks; what is not shown yet when the next one comes is not shown at all.
    virtual void show(const Display& display) = 0;
    /// Nothing will come any more.
    [[nodiscard]] virtual bool ended() const = 0;
    /// It goes by the PC's clock: time must not be made to pass faster than that.
    [[nodiscard]] virtual bool real() const = 0;
};

}  // namespace sc::host::pendant
