// SPDX-License-Identifier: Apache-2.0
#include "host/cli/measure_live.hpp"

#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>

#include <poll.h>
#include <unistd.h>

#include "host/bridge/stop.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/cli/live_page.hpp"
#include "host/formats/error.hpp"
#include "host/formats/text.hpp"
#include "host/measurement/station_view.hpp"

namespace sc::host::cli {
namespace {

constexpr std::size_t kLatest = 10;
constexpr int kWaitMs = 100;

/// Whole lines of a file that grows, or of stdin.
class Follower {
public:
    explicit Follower(const std::string& name) : name_(name) {
        if (name != "-") {
            file_.open(name, std::ios::binary);
            if (!file_) {
                throw InputError({.file = name,
                                  .problem = "cannot be read",
                                  .value = {},
                                  .action = "name a file that is there, or - for stdin"});
            }
        }
    }

    std::optional<std::string> next() {
        while (true) {
            if (const std::size_t end = held_.find('\n'); end != std::string::npos) {
                std::string line = held_.substr(0, end);
                held_.erase(0, end + 1);
                return line;
            }
            std::array<char, 4096> buffer{};
            const std::optional<std::size_t> got = name_ == "-" ? from_stdin(buffer) : from_file(buffer);
            if (!got) {
                return std::nullopt;
            }
            if (*got == 0) {
                return std::string();
            }
            held_.append(buffer.data(), *got);
        }
    }

private:
    static std::optional<std::size_t> from_stdin(std::array<char, 4096>& buffer) {
        pollfd waiting{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        if (::poll(&waiting, 1, kWaitMs) <= 0) {
            return 0;
        }
        const ssize_t got = ::read(STDIN_FILENO, buffer.data(), buffer.size());
        return got > 0 ? std::optional<std::size_t>(static_cast<std::size_t>(got)) : std::nullopt;
    }

    std::optional<std::size_t> from_file(std::array<char, 4096>& buffer) {
        file_.clear();
        file_.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
        const auto got = static_cast<std::size_t>(file_.gcount());
        if (got == 0) {
            ::poll(nullptr, 0, kWaitMs);
        }
        return got;
    }

    std::string name_;
    std::ifstream file_;
    std::string held_;
};

/// The latest readings of the station that is being measured.
class Latest {
public:
    explicit Latest(std::string file) : file_(std::move(file)) {}

    /// True when there is something new to show. A row that cannot be understood is said, and is none.
    bool take(const std::string& line) {
        ++number_;
        const std::string_view text = trimmed(line);
        if (text.empty() || text.front() == '#') {
            return false;
        }
        if (header_.empty()) {
            header_ = line;
            return false;
        }
        try {
            Station now = parse_stations("row", header_ + "\n" + line + "\n").stations.front();
            const HeadReading reading = now.readings.front();
            if (now.id != station_.id || now.sensors != station_.sensors) {
                station_ = std::move(now);
            } else {
                station_.readings.push_back(reading);
            }
            if (station_.readings.size() > kLatest) {
                station_.readings.erase(station_.readings.begin());
            }
            return true;
        } catch (const InputError& error) {
            std::fprintf(stderr, "%s:%d: left out: %s: %s\n", file_.c_str(), number_, error.problem().c_str(),
                         error.value().c_str());
            return false;
        }
    }
    [[nodiscard]] const Station& station() const { return station_; }

private:
    std::string file_;
    std::string header_;
    int number_ = 0;
    Station station_;
};

}  // namespace

LineSource line_source(const std::string& readings) {
    const auto follower = std::make_shared<Follower>(readings);
    return [follower] { return follower->next(); };
}

int measure_live(const LiveOptions& options) {
    using Clock = std::chrono::steady_clock;
    LivePage page(options.port);
    std::fprintf(stderr, "page: http://127.0.0.1:%d/ (Ctrl-C ends)\n", page.port());
    Latest latest(options.name);
    const StationRefusal nothing{StationProblem::too_few, "no reading has come yet"};
    page.show(svg_of(refusal_drawing("-", nothing)));
    const bool terminal = ::isatty(STDOUT_FILENO) == 1;
    auto last_line = Clock::now();
    bool refused = true;
    int taken = 0;
    while (!stop_requested() && (options.most == 0 || taken < options.most)) {
        page.serve(0);
        const std::optional<std::string> line = options.source();
        if (!line) {
            break;
        }
        if (line->empty()) {
            if (Clock::now() - last_line > std::chrono::duration<double>(options.idle_s)) {
                std::fprintf(stderr, "no reading for %.1f s: ended\n", options.idle_s);
                break;
            }
            continue;
        }
        last_line = Clock::now();
        if (!latest.take(*line)) {
            continue;
        }
        ++taken;
        if (latest.station().readings.size() < options.options.fewest) {
            continue;
        }
        const auto result = measure_station(options.head, latest.station(), options.options);
        refused = !result;
        if (!result) {
            page.show(svg_of(refusal_drawing(latest.station().id, result.error())));
            std::printf("%sstation %s: no figures, %s: %s\n", terminal ? "\033[2J\033[H" : "",
                        latest.station().id.c_str(), name_of(result.error().problem), result.error().text.c_str());
            std::fflush(stdout);
            continue;
        }
        std::optional<Correction> correction;
        if (options.job.target && !options.job.target->same) {
            correction = correction_of(*result, *options.job.target, options.job);
        }
        page.show(svg_of(station_drawing(*result, correction ? &*correction : nullptr)));
        // A terminal shows the views, drawn over and over; a file gets a line a reading.
        std::printf("%s%s", terminal ? "\033[2J\033[H" : "",
                    terminal ? station_page(*result, correction ? &*correction : nullptr).c_str()
                             : table_row(*result, correction ? &*correction : nullptr).c_str());
        std::fflush(stdout);
    }
    page.serve(0);
    if (stop_requested()) {
        return kExitInterrupted;
    }
    return refused ? kFailed : kDone;
}

}  // namespace sc::host::cli
