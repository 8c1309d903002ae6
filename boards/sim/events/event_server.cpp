// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/events/event_server.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <poll.h>
#include <sys/socket.h>

#include "boards/sim/trace_file.hpp"

namespace sc::sim {
namespace {

using event_device::Packet;

constexpr int kPollMs = 50;

/// Text that grows as FILE.part and takes its name at the end.
class EventFile {
public:
    explicit EventFile(const std::filesystem::path& path) : path_(path) {
        if (path.empty()) {
            return;
        }
        if (path.has_parent_path()) {
            std::filesystem::create_directories(path.parent_path());
        }
        file_.open(path.string() + ".part", std::ios::binary | std::ios::trunc);
        check();
        file_ << "# t_ns event value\n";
    }
    void line(std::int64_t t_ns, std::string_view what, std::int64_t value) {
        if (file_.is_open()) {
            file_ << t_ns << ' ' << what << ' ' << value << '\n';
            // Whoever looks at it when the light has gone finds all pulses there.
            if (what != "pulse") {
                file_.flush();
            }
        }
    }
    void close() {
        if (file_.is_open()) {
            file_.close();
            check();
            std::filesystem::rename(path_.string() + ".part", path_);
        }
    }

private:
    void check() const {
        if (!file_) {
            throw std::system_error(errno, std::generic_category(), path_.string());
        }
    }
    std::filesystem::path path_;
    std::ofstream file_;
};

class Server {
public:
    Server(int socket, const EventServerOptions& options)
        : socket_(socket),
          options_(options),
          file_(options.out),
          packet_(event_device::kPacketCapacity + 1),
          outputs_(std::make_unique<ServoOutputs>()) {}

    EventReport run(const volatile bool* stop) {
        std::int64_t quiet_ms = 0;
        while (!*stop) {
            pollfd wait{socket_, POLLIN, 0};
            const int ready = ::poll(&wait, 1, kPollMs);
            if (ready <= 0) {
                quiet_ms += kPollMs;
                if (player_ && options_.watchdog_ms > 0 && quiet_ms >= options_.watchdog_ms) {
                    player_->shut();
                }
                continue;
            }
            quiet_ms = 0;
            if (!take()) {
                break;
            }
        }
        if (!player_) {
            return {};
        }
        player_->shut();
        file_.close();
        const EventReport report = player_->report();
        if (!options_.out.empty()) {
            write_whole_file(options_.out.string() + ".json", to_json(report) + "\n");
        }
        return report;
    }

private:
    /// False when the controller has gone.
    bool take() {
        const ssize_t n = ::recv(socket_, packet_.data(), packet_.size(), 0);
        if (n <= 0) {
            return n < 0 && errno == EINTR;
        }
        const auto bytes = std::span<const std::uint8_t>(packet_).first(static_cast<std::size_t>(n));
        if (!player_) {
            MachineConfig machine;
            if (!event_device::get_begin(bytes, machine)) {
                throw std::runtime_error("the controller's first packet is no beginning of this version");
            }
            player_ = std::make_unique<EventPlayer>(machine, [this](std::int64_t t_ns, std::string_view what,
                                                                    std::int64_t v) { file_.line(t_ns, what, v); });
            return true;
        }
        std::int64_t tick = 0;
        std::uint8_t causes = 0;
        if (event_device::get_veto(bytes, causes)) {
            player_->veto(causes);
        } else if (event_device::get_window(bytes, tick, *outputs_)) {
            player_->window(tick, *outputs_);
            std::array<std::uint8_t, event_device::kStatusCapacity> reply{};
            const std::size_t size = event_device::put_status(player_->status(), reply);
            (void)::send(socket_, reply.data(), size, MSG_NOSIGNAL | MSG_DONTWAIT);
        } else {
            throw std::runtime_error("a packet of " + std::to_string(n) + " bytes is none of a controller's");
        }
        return true;
    }

    int socket_;
    EventServerOptions options_;
    EventFile file_;
    std::vector<std::uint8_t> packet_;
    std::unique_ptr<ServoOutputs> outputs_;
    std::unique_ptr<EventPlayer> player_;
};

}  // namespace

EventReport serve_events(int socket, const EventServerOptions& options, const volatile bool* stop) {
    return Server(socket, options).run(stop);
}

}  // namespace sc::sim
