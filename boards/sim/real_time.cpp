// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/real_time.hpp"

#include <array>
#include <chrono>
#include <span>
#include <vector>

#include <poll.h>
#include <spdlog/spdlog.h>

namespace sc::sim {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::int64_t kSlipNs = 200'000'000;

/// Which time the cell should have now.
class Pace {
public:
    Pace(std::int64_t cell_ns, double speed) : speed_(speed) { restart(cell_ns); }
    [[nodiscard]] std::int64_t due_ns() const {
        const std::chrono::duration<double, std::nano> elapsed = Clock::now() - begin_;
        return cell_begin_ns_ + static_cast<std::int64_t>(elapsed.count() * speed_);
    }
    void restart(std::int64_t cell_ns) {
        begin_ = Clock::now();
        cell_begin_ns_ = cell_ns;
    }
    [[nodiscard]] timespec wait_for(std::int64_t cell_ns) const {
        const double ns = static_cast<double>(cell_ns - due_ns()) / speed_;
        const auto whole = ns > 0.0 ? static_cast<std::int64_t>(ns) : 0;
        return {static_cast<time_t>(whole / 1'000'000'000), static_cast<long>(whole % 1'000'000'000)};
    }

private:
    double speed_;
    Clock::time_point begin_;
    std::int64_t cell_begin_ns_ = 0;
};

void exchange(SimCell& cell, port::Port& port, std::vector<std::uint8_t>& buffer) {
    buffer.clear();
    if (cell.take_link(buffer) > 0) {
        port.send(buffer);
    }
    std::array<std::uint8_t, 4096> received{};
    while (const std::size_t n = port.receive(received)) {
        cell.push_link(std::span(received).first(n));
    }
}

}  // namespace

void serve_real_time(SimCell& cell, port::Port& port, double speed, const volatile bool* stop) {
    Pace pace(cell.now_ns(), speed);
    std::vector<std::uint8_t> buffer;
    while (!*stop) {
        const std::int64_t due = pace.due_ns();
        if (due - cell.now_ns() > kSlipNs) {
            spdlog::warn("the cell is {:.1f} s behind real time; its time slips",
                         static_cast<double>(due - cell.now_ns()) * 1e-9);
            pace.restart(cell.now_ns());
        }
        if (cell.now_ns() <= due) {
            exchange(cell, port, buffer);
            cell.tick();
            continue;
        }
        pollfd wait{port.file(), POLLIN, 0};
        const timespec timeout = pace.wait_for(cell.now_ns());
        ::ppoll(&wait, 1, &timeout, nullptr);
    }
}

}  // namespace sc::sim
