// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/open_transport.hpp"

#include <chrono>
#include <utility>
#include <vector>

#include <sys/socket.h>
#include <sys/un.h>

#include "host/bridge/can_transport.hpp"
#include "host/bridge/capture_transport.hpp"
#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/fd_transport.hpp"
#include "host/bridge/link_url.hpp"
#include "host/bridge/sim_transport.hpp"
#include "host/bridge/socket_can_transport.hpp"
#include "host/bridge/unique_fd.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

constexpr const char* kCellProgram = "scribecell-cell";
constexpr int kExitBadInput = 2;

/// A simulated cell and the carrier to it, which ends it.
class SimTransport final : public Transport {
public:
    SimTransport(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                 const LockStepTransport::Options& options)
        : cell_(program, arguments), link_(cell_.socket(), options) {}

    void send(std::span<const std::uint8_t> bytes) override { link_.send(bytes); }
    std::size_t receive(std::span<std::uint8_t> out, HostTime until) override {
        const std::size_t n = link_.receive(out, until);
        if (n == 0 && link_.closed()) {
            report_end();
        }
        return n;
    }
    [[nodiscard]] HostTime now() const override { return link_.now(); }
    [[nodiscard]] bool closed() const override { return link_.closed(); }

private:
    /// The cell does not end before its socket closes, unless it refuses its files or breaks.
    void report_end() {
        const int code = cell_.finish();
        if (code == kExitBadInput) {
            throw InputError({.file = {},
                              .problem = "the simulated cell refused its input (its message stands above)",
                              .value = {},
                              .action = "correct the world, the script or the image"});
        }
        throw LinkError("the simulated cell ended by itself with code " + std::to_string(code) +
                        ": report this, with its messages above");
    }

    ChildProcess cell_;
    LockStepTransport link_;
};

/// A simulated cell that somebody else has started and that outlives this host.
class LastingCell final : public Transport {
public:
    LastingCell(UniqueFd socket, const LockStepTransport::Options& options)
        : socket_(std::move(socket)), link_(socket_.get(), options) {
        link_.learn_time();
    }
    void send(std::span<const std::uint8_t> bytes) override { link_.send(bytes); }
    std::size_t receive(std::span<std::uint8_t> out, HostTime until) override { return link_.receive(out, until); }
    [[nodiscard]] HostTime now() const override { return link_.now(); }
    [[nodiscard]] bool closed() const override { return link_.closed(); }

private:
    UniqueFd socket_;
    LockStepTransport link_;
};

std::unique_ptr<Transport> open_lock_step(const std::string& path, const LinkOptions& options) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof(address.sun_path)) {
        throw InputError(
            {.file = path, .problem = "is too long for a socket's path", .value = {}, .action = "use a shorter one"});
    }
    path.copy(static_cast<char*>(address.sun_path), sizeof(address.sun_path) - 1);
    UniqueFd socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the form that connect wants
    const auto* pointer = reinterpret_cast<const sockaddr*>(&address);
    if (socket.get() < 0 || ::connect(socket.get(), pointer, sizeof(address)) != 0) {
        throw LinkError("no cell listens at " + path + ": start one with scribecell-cell --lockstep " + path);
    }
    return std::make_unique<LastingCell>(std::move(socket),
                                         LockStepTransport::Options{.jitter = options.jitter, .seed = options.seed});
}

const char* name_of(SimCarrier carrier) {
    switch (carrier) {
        case SimCarrier::serial: return "serial";
        case SimCarrier::can: return "can";
        case SimCarrier::canfd: return "canfd";
    }
    return "";
}

std::vector<std::string> cell_arguments(const LinkOptions& options, SimCarrier carrier) {
    std::vector<std::string> words{"--lockstep-fd", std::to_string(ChildProcess::kChildSocket)};
    const auto add = [&words](const char* name, const std::string& value) {
        words.emplace_back(name);
        words.push_back(value);
    };
    if (options.world) {
        add("--world", options.world->string());
    }
    if (options.key) {
        add("--key", options.key->string());
    }
    if (options.out) {
        add("--out", options.out->string());
    }
    if (options.script) {
        add("--script", options.script->string());
    }
    if (options.memory) {
        add("--memory", options.memory->string());
    }
    if (options.record) {
        add("--record", options.record->string());
        add("--record-limit", std::to_string(options.record_limit_mb));
    }
    if (carrier != SimCarrier::serial) {
        add("--carrier", name_of(carrier));
    }
    if (options.baud) {
        add("--baud", std::to_string(*options.baud));
    }
    if (options.board == "m7") {
        add("--controller", "m7");
    }
    if (options.prr_nominal_hz) {
        add("--prr-nominal", std::to_string(*options.prr_nominal_hz));
    }
    for (const std::string& setting : options.machine) {
        add("--machine", setting);
    }
    if (options.m7_image) {
        add("--m7-image", options.m7_image->string());
    }
    return words;
}

std::unique_ptr<Transport> start_simulated(const LinkOptions& options, SimCarrier carrier) {
    const auto program = find_program(kCellProgram);
    if (!program) {
        throw LinkError("the program scribecell-cell is not there: build it (./run does), or set SCRIBECELL_ROOT");
    }
    const LockStepTransport::Options lock_step{.jitter = options.jitter, .seed = options.seed};
    return std::make_unique<SimTransport>(*program, cell_arguments(options, carrier), lock_step);
}

std::unique_ptr<Transport> open_carrier(const LinkUrl& url, const LinkOptions& options) {
    if (const auto* serial = std::get_if<SerialUrl>(&url)) {
        return open_serial(serial->device, serial->baud);
    }
    if (const auto* tcp = std::get_if<TcpUrl>(&url)) {
        return open_tcp(tcp->host, tcp->port);
    }
    if (const auto* can = std::get_if<CanUrl>(&url)) {
        return open_socket_can(can->interface, can->fd);
    }
    if (const auto* lasting = std::get_if<LockStepUrl>(&url)) {
        return open_lock_step(lasting->path, options);
    }
    return start_simulated(options, std::get<SimulatedUrl>(url).carrier);
}

/// Serial lines and TCP carry bytes, a bus carries frames; simulated cells have a choice.
SimCarrier carrier_of(const LinkUrl& url) {
    if (const auto* can = std::get_if<CanUrl>(&url)) {
        return can->fd ? SimCarrier::canfd : SimCarrier::can;
    }
    if (const auto* simulated = std::get_if<SimulatedUrl>(&url)) {
        return simulated->carrier;
    }
    const auto* lasting = std::get_if<LockStepUrl>(&url);
    return lasting != nullptr ? lasting->carrier : SimCarrier::serial;
}

/// Captures of real links carry the time of day, of simulated ones the cell's own.
Nanoseconds capture_offset(const LinkUrl& url, const Transport& carrier) {
    if (std::holds_alternative<SimulatedUrl>(url) || std::holds_alternative<LockStepUrl>(url)) {
        return Nanoseconds::zero();
    }
    const auto today = std::chrono::system_clock::now().time_since_epoch();
    return std::chrono::duration_cast<Nanoseconds>(today) - carrier.now().time_since_epoch();
}

}  // namespace

std::unique_ptr<Transport> open_transport(const std::string& url, const LinkOptions& options) {
    const LinkUrl parsed = parse_link_url(url);
    const SimCarrier kind = carrier_of(parsed);
    std::unique_ptr<CaptureWriter> capture;
    if (options.capture) {
        capture = std::make_unique<CaptureWriter>(*options.capture,
                                                  kind == SimCarrier::serial ? CaptureKind::serial : CaptureKind::can);
    }
    std::unique_ptr<Transport> carrier = open_carrier(parsed, options);
    if (kind != SimCarrier::serial) {
        const Nanoseconds offset = capture_offset(parsed, *carrier);
        return std::make_unique<CanTransport>(std::move(carrier), kind == SimCarrier::canfd, std::move(capture),
                                              offset);
    }
    if (capture) {
        const Nanoseconds offset = capture_offset(parsed, *carrier);
        return std::make_unique<CaptureTransport>(std::move(carrier), std::move(capture), offset);
    }
    return carrier;
}

std::uint32_t line_bytes_per_s(const std::string& url, const LinkOptions& options) {
    constexpr unsigned kSimulatedBaud = 921'600;
    constexpr unsigned kBitsPerByte = 10;
    const LinkUrl parsed = parse_link_url(url);
    if (const auto* serial = std::get_if<SerialUrl>(&parsed)) {
        return serial->baud / kBitsPerByte;
    }
    if (std::holds_alternative<CanUrl>(parsed)) {
        return 0;
    }
    return options.baud.value_or(kSimulatedBaud) / kBitsPerByte;
}

bool is_simulated(const std::string& url) { return std::holds_alternative<SimulatedUrl>(parse_link_url(url)); }

}  // namespace sc::host
