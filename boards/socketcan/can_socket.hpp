// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sc::socketcan {

inline constexpr std::size_t kClassicBytes = 8;
inline constexpr std::size_t kFdBytes = 64;

struct CanFrame {
    std::uint32_t id = 0;  ///< 11 bits, 29 when `extended`
    bool extended = false;
    bool remote = false;  ///< classic only; carries no data
    bool fd = false;
    bool fast = false;      ///< FD: with the rate of the data phase (BRS)
    std::uint8_t size = 0;  ///< bytes; FD: one of 0..8, 12, 16, 20, 24, 32, 48, 64
    std::array<std::uint8_t, kFdBytes> data{};
    std::int64_t time_ns = 0;  ///< received: CLOCK_REALTIME by the kernel
};

/// A frame is heard if (its id & mask) == (id & mask); data frames of 11-bit ids only.
struct CanFilter {
    std::uint32_t id = 0;
    std::uint32_t mask = 0x7FF;
};

struct CanOptions {
    bool fd = false;                   ///< FD frames may be sent and are heard
    std::vector<CanFilter> filters{};  ///< empty: all is heard
};

enum class CanSent : std::uint8_t {
    yes,
    full,    ///< ENOBUFS or EAGAIN: no room in the interface's queue; try again later
    down,    ///< the interface is down or gone
    failed,  ///< refused by the kernel (wrong size, FD on a classic interface)
};

/// What the controller's error frames and the socket tell of the bus.
enum class BusState : std::uint8_t {
    active,
    warning,  ///< an error counter is above 96
    passive,  ///< above 127
    bus_off,  ///< until the controller restarts (`ip link set IFACE type can restart-ms 100`)
    down,     ///< the interface is down or gone
};

struct CanCounters {
    std::uint64_t sent = 0;
    std::uint64_t received = 0;
    std::uint64_t full = 0;       ///< sends that found no room
    std::uint64_t down = 0;       ///< sends and reads that found the interface down
    std::uint64_t failed = 0;     ///< sends that were refused
    std::uint64_t malformed = 0;  ///< packets that were no frame
    std::uint64_t dropped = 0;    ///< received, but the socket's own queue was full
    std::uint64_t errors = 0;     ///< error frames
    std::uint64_t bus_offs = 0;
    std::uint64_t restarts = 0;
    std::uint64_t no_acks = 0;  ///< nobody else is on the bus
    std::uint64_t lost_arbitrations = 0;
    std::uint64_t overflows = 0;      ///< of the controller, either way
    std::uint8_t tx_error_count = 0;  ///< as the last error frame told
    std::uint8_t rx_error_count = 0;
};

/// A raw CAN socket. No call but the constructors blocks or allocates; one system call each. One thread at a time.
class CanSocket {
public:
    using Frame = CanFrame;

    /// Opens the interface. Throws std::system_error; its text says what is missing (no CAN in the kernel, no such
    /// interface, FD on an interface of classic frames).
    explicit CanSocket(const std::string& interface, const CanOptions& options = {});
    /// Takes an open socket that carries struct can_frame and canfd_frame as packets; closed with this.
    explicit CanSocket(int file, const CanOptions& options = {});
    CanSocket(CanSocket&& other) noexcept;
    CanSocket& operator=(CanSocket&& other) noexcept;
    CanSocket(const CanSocket&) = delete;
    CanSocket& operator=(const CanSocket&) = delete;
    ~CanSocket();

    [[nodiscard]] CanSent send(const CanFrame& frame) noexcept;
    /// The next frame; false when none waits. Error frames are not handed over but counted.
    [[nodiscard]] bool receive(CanFrame& out) noexcept;
    [[nodiscard]] BusState state() const noexcept { return state_; }
    [[nodiscard]] const CanCounters& counters() const noexcept { return counters_; }
    /// To wait on with poll.
    [[nodiscard]] int file() const noexcept { return file_; }
    /// The peer of a socket pair has gone; never of an interface.
    [[nodiscard]] bool closed() const noexcept { return closed_; }

private:
    void close() noexcept;
    [[nodiscard]] CanSent refused(int error) noexcept;
    void note_error(std::uint32_t id, std::span<const std::uint8_t, kClassicBytes> data) noexcept;

    int file_ = -1;
    bool paired_ = false;
    bool closed_ = false;
    BusState state_ = BusState::active;
    CanCounters counters_;
};

/// Whether a data length is one that FD frames have.
[[nodiscard]] bool is_fd_size(std::size_t size) noexcept;

}  // namespace sc::socketcan
