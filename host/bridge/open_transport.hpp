// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/bridge/transport.hpp"

namespace sc::host {

/// What a link needs besides its URL. Only the simulated cell uses what is neither `capture` nor `key`.
struct LinkOptions {
    std::optional<std::filesystem::path> capture;   ///< pcap file of all that passes (host/formats/capture_file.hpp)
    std::optional<std::filesystem::path> key;       ///< file of the cell's key (key_file.hpp); none: unsealed
    std::optional<std::filesystem::path> world;     ///< world file; the cell's default without one
    std::optional<std::filesystem::path> out;       ///< folder for the cell's traces
    std::optional<std::filesystem::path> script;    ///< faults to provoke, by virtual time
    Nanoseconds jitter{0};                          ///< arrival jitter of what the host sends
    std::uint64_t seed = 1;                         ///< of the jitter
    std::optional<unsigned> baud;                   ///< rate of the simulated carrier
    std::string board = "sim";                      ///< where the cell's controller runs: sim (on this PC) or m7
    std::optional<std::filesystem::path> m7_image;  ///< image of the board m7; the project's own without one
    std::optional<std::filesystem::path> record;    ///< log of the controller's inputs, for `scribecell replay`
    std::optional<std::filesystem::path> memory;    ///< file of what the simulated cell keeps without power
    double record_limit_mb = 100.0;                 ///< where the log ends; the cell goes on
    std::optional<double> prr_nominal_hz;           ///< of the cell's laser; the reference cell's without one
    std::vector<std::string> machine;               ///< KEY=VALUE, as scribecell-cell --machine takes them
};

/// Opens the cell named by `url`:
///
///     sim:                          the simulated cell, started by this call, in lock-step virtual time
///     sim:?carrier=can              the same over a simulated bus: can (1 Mbit/s), canfd (1 and 5 Mbit/s) or serial
///     can:can0                      a CAN bus (SocketCAN), classic frames; ?fd=1: FD frames
///     serial:/dev/ttyUSB0?baud=N    a serial line or pseudo-terminal (8N1; without baud the speed stays as it is)
///     tcp:127.0.0.1:7000            a cell on a TCP port
///     lockstep:cell.socket          a simulated cell that listens there (scribecell-cell --lockstep), in virtual time;
///                                   ?carrier= as above, if it was started with --carrier
///
/// Throws InputError for a URL that is none or an interface that is not there, LinkError when the cell cannot be
/// reached. For `sim:` the returned carrier ends the cell when destroyed, and waits until its traces are written.
[[nodiscard]] std::unique_ptr<Transport> open_transport(const std::string& url, const LinkOptions& options);

/// Bytes a second that the carrier takes each way: a serial line's baud over ten, of a simulated or a TCP cell what its
/// simulated carrier takes. 0: not known (a serial line whose speed the URL does not say, a CAN bus). Throws InputError
/// as above.
[[nodiscard]] std::uint32_t line_bytes_per_s(const std::string& url, const LinkOptions& options);

/// True when the URL starts a simulated cell of its own.
[[nodiscard]] bool is_simulated(const std::string& url);

}  // namespace sc::host
