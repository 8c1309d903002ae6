// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "boards/sim/events/event_server.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr const char* kExamples = R"(Examples:
  scribecell-events /run/scribecell/events --out run1/events.trace
      plays the laser events of one controller after another; the trace of each gets its name when the controller goes
  scribecell-events events.socket --out events.trace --once --json
      ends with the first controller, and prints what was played as one JSON object

Exit codes: 0 done; 1 failed; 2 bad input or usage.)";

volatile bool stop_asked = false;

void ask_stop(int) { stop_asked = true; }

struct Arguments {
    std::string socket;
    sc::sim::EventServerOptions options;
    bool once = false;
    bool json = false;
};

/// Closes it and takes the name away.
class Listener {
public:
    explicit Listener(std::string path) : path_(std::move(path)) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        if (path_.empty() || path_.size() >= sizeof address.sun_path) {
            throw std::system_error(ENAMETOOLONG, std::generic_category(), path_);
        }
        path_.copy(static_cast<char*>(address.sun_path), sizeof address.sun_path - 1);
        ::unlink(path_.c_str());
        file_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
        // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the socket interface wants it.
        if (file_ < 0 || ::bind(file_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
            ::listen(file_, 1) != 0) {
            throw std::system_error(errno, std::generic_category(), "listen at " + path_);
        }
    }
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;
    ~Listener() {
        ::close(file_);
        ::unlink(path_.c_str());
    }
    /// −1 when a signal came.
    [[nodiscard]] int accept() const {
        while (!stop_asked) {
            pollfd wait{file_, POLLIN, 0};
            if (::poll(&wait, 1, 100) > 0) {
                return ::accept4(file_, nullptr, nullptr, SOCK_CLOEXEC);
            }
        }
        return -1;
    }

private:
    std::string path_;
    int file_ = -1;
};

int run(const Arguments& a) {
    const Listener listener(a.socket);
    do {
        const int client = listener.accept();
        if (client < 0) {
            break;
        }
        const sc::sim::EventReport report = sc::sim::serve_events(client, a.options, &stop_asked);
        ::close(client);
        if (a.json) {
            std::printf("%s\n", to_json(report).c_str());
        } else {
            std::printf("%llu windows, %llu pulses, command trace %s\n",
                        static_cast<unsigned long long>(report.windows), static_cast<unsigned long long>(report.pulses),
                        report.command_trace_sha256.c_str());
        }
        std::fflush(stdout);
    } while (!a.once && !stop_asked);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"A simulated event device: laser, source and shutter for a controller on Linux.", "scribecell-events"};
    try {
        Arguments arguments;
        app.footer(kExamples);
        app.add_option("socket", arguments.socket, "path of the socket at which the controller finds the device")
            ->required();
        app.add_option("--out", arguments.options.out, "trace of what was played; FILE.json beside it")
            ->type_name("FILE");
        app.add_option("--watchdog", arguments.options.watchdog_ms,
                       "ms; without a window for so long the gate is shut, 0: never")
            ->check(CLI::Range(0, 60'000))
            ->capture_default_str();
        app.add_flag("--once", arguments.once, "end with the first controller");
        app.add_flag("--json", arguments.json, "print one JSON object a controller");
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        struct sigaction action{};
        action.sa_handler = ask_stop;
        ::sigaction(SIGTERM, &action, nullptr);
        ::sigaction(SIGINT, &action, nullptr);
        return run(arguments);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-events: %s\n", error.what());
        return kFailed;
    }
}
