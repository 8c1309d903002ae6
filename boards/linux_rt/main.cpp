// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "boards/drive_file/drive_file.hpp"
#include "boards/linux_rt/gpio_lines.hpp"
#include "boards/linux_rt/options.hpp"
#include "boards/linux_rt/report.hpp"
#include "boards/linux_rt/service_notify.hpp"
#include "boards/machine_file/machine_file.hpp"
#include "boards/memory/retained_file.hpp"
#include "boards/replay/key_file.hpp"

namespace {

using namespace sc;
using namespace sc::linux_rt;

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr long kLookNs = 100'000'000;

/// Everything that the loop hangs on; made before the loop's thread and gone after it.
struct Cell {
    MachineConfig machine;
    std::unique_ptr<DriveBus> drives;
    std::unique_ptr<HostLink> link;
    std::unique_ptr<LinePort> lines;
    std::unique_ptr<GateLine> gate;
    std::unique_ptr<event_device::EventLink> events;
    std::unique_ptr<LaserHead> head;
    std::vector<std::unique_ptr<rs485::ModbusPort>> sensors;
    std::unique_ptr<memory::RetainedFile> memory;
    std::unique_ptr<ControlLoop> loop;
};

std::uint32_t boot_id_of(const Options& o) {
    return o.boot_id != 0 ? o.boot_id : static_cast<std::uint32_t>(std::time(nullptr));
}

/// What a job may ask of a laser that hangs on a line.
void tell_of_gate(const MachineConfig& machine) {
    const double tick_s = static_cast<double>(machine.control_period_ns) * 1e-9;
    std::fprintf(stderr,
                 "scribecell-rt: the laser hangs on a line: a place is off by up to speed x %.3g ms (%.3g mm at "
                 "%.3g mm/s); jobs whose pitch is finer are refused\n",
                 1e3 * tick_s, 1e3 * tick_s * machine.axis[0].speed, 1e3 * machine.axis[0].speed);
}

std::unique_ptr<Cell> make_cell(const Options& o) {
    auto cell = std::make_unique<Cell>();
    cell->machine = reference_machine();
    DrivePlan plan = kPlainDrives;
    if (!o.machine.empty()) {
        cell->machine = machine_file::read_machine(o.machine);
        plan = drive_file::read_drive_file(o.machine, cell->machine).plan;
    }
    restrict_to_axes(cell->machine);
    if (!o.gate.empty()) {
        restrict_to_gate(cell->machine);
        tell_of_gate(cell->machine);
    }
    cell->drives = std::make_unique<DriveBus>(open_drive_buses(o.drive_bus));
    cell->link = open_host_link(o.link);
    GpioLines* gpio = nullptr;
    if (o.lines_closed) {
        cell->lines = std::make_unique<ClosedLines>();
    } else {
        auto lines = std::make_unique<GpioLines>(parse_wiring(o.gpio));
        gpio = lines.get();
        cell->lines = std::move(lines);
    }
    if (gpio != nullptr && !o.gate.empty()) {
        cell->gate = std::make_unique<GpioGate>(*gpio);
        cell->head = std::make_unique<GatedHead>(*cell->gate);
    } else if (!o.events.empty()) {
        cell->events = std::make_unique<event_device::EventLink>(o.events, cell->machine);
        cell->head = std::make_unique<EventHead>(*cell->events);
    } else {
        cell->head = std::make_unique<NoLaser>();
    }
    LoopParts parts{cell->drives.get(), cell->link.get(), cell->lines.get(), cell->head.get(), {}};
    for (const SensorPort& port : sensor_ports(o.sensors)) {
        cell->sensors.push_back(
            std::make_unique<rs485::ModbusPort>(port.device, cell->machine.sensors.bus.at(port.bus)));
        parts.sensors.at(port.bus) = cell->sensors.back().get();
    }
    cell->memory = std::make_unique<memory::RetainedFile>(o.memory);
    cell->loop = std::make_unique<ControlLoop>(cell->machine, boot_id_of(o),
                                               o.memory.empty() ? nullptr : cell->memory->memory(), parts, plan);
    if (!cell->loop->controller().drive_budget()) {
        throw std::invalid_argument("the drive bus cannot carry this:\n" +
                                    drive_file::budget_text(cell->machine, plan));
    }
    if (!o.key.empty()) {
        cell->loop->controller().fit_key(replay::secret_of(replay::read_key_file(o.key)));
    }
    return cell;
}

/// False when it may not run.
bool prepare_real_time(const Options& o) {
    const std::vector<std::string> missing = missing_for_real_time(o.real_time);
    for (const std::string& one : missing) {
        std::fprintf(stderr, "scribecell-rt: %s: %s\n", o.no_real_time ? "warning" : "not real-time", one.c_str());
    }
    if (o.no_real_time) {
        std::fprintf(stderr, "scribecell-rt: warning: without real time axes may fault and the laser must stay off\n");
        return true;
    }
    if (!missing.empty()) {
        std::fprintf(stderr, "scribecell-rt: refused; --no-rt runs all the same, for tests without a laser\n");
        return false;
    }
    lock_memory();
    return true;
}

const char* text_of(RunEnd end) {
    switch (end) {
        case RunEnd::stopped: return "ended as asked";
        case RunEnd::overruns: return "ended: the loop does not keep its period";
        case RunEnd::not_stopped: return "ended: the axes did not come to rest without power within 3 s";
    }
    return "";
}

void print(const RunFigures& figures, bool json) {
    const std::string text = json ? to_json(figures) + "\n" : to_text(figures);
    std::fputs(text.c_str(), stdout);
    std::fflush(stdout);
}

/// Signals and the service manager, until the loop's thread has ended.
void attend(const sigset_t& signals, const RunFigures& figures, bool json, std::atomic<bool>& stop,
            const std::atomic<bool>& ended) {
    const ServiceNotify manager;
    manager.say("READY=1");
    std::int64_t seen = -1;
    while (!ended.load()) {
        const timespec look{0, kLookNs};
        const int signal = ::sigtimedwait(&signals, nullptr, &look);
        if (signal == SIGTERM || signal == SIGINT) {
            manager.say("STOPPING=1");
            stop.store(true);
        } else if (signal == SIGUSR1) {
            print(figures, json);
        }
        // A loop that stands still is not alive, whatever this thread is.
        if (const std::int64_t ticks = figures.runner->ticks(); ticks != seen) {
            seen = ticks;
            manager.say("WATCHDOG=1");
        }
    }
}

int run(const Options& o) {
    check(o);
    sigset_t signals;
    ::sigemptyset(&signals);
    for (const int signal : {SIGTERM, SIGINT, SIGUSR1}) {
        ::sigaddset(&signals, signal);
    }
    ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    if (!prepare_real_time(o)) {
        return kBadInput;
    }
    const AwakeProcessors awake;
    const std::unique_ptr<Cell> cell = make_cell(o);
    std::fprintf(stderr, "scribecell-rt: drives on %s, host on %s\n", o.drive_bus.c_str(), cell->link->name().c_str());

    SystemClock clock;
    RunnerOptions options;
    options.pace = o.pace == "drives" ? Pace::drives : Pace::time;
    options.answer_timeout_ns = std::int64_t{o.answer_timeout_ms} * 1'000'000;
    options.most_overruns = o.no_real_time ? 0 : o.most_overruns;
    const auto period = static_cast<std::int64_t>(static_cast<double>(cell->machine.control_period_ns) * o.slow);
    Runner runner(*cell->loop, *cell->drives, clock, period, options);

    std::atomic<bool> stop{false};
    std::atomic<bool> ended{false};
    RunEnd end = RunEnd::stopped;
    std::exception_ptr trouble;
    std::thread thread([&] {
        try {
            if (!o.no_real_time) {
                make_thread_real_time(o.real_time);
            }
            end = runner.run(stop);
        } catch (...) {
            trouble = std::current_exception();
        }
        ended.store(true);
    });
    const RunFigures figures{&runner, cell->loop.get(), cell->drives.get(), cell->link.get(), cell->events.get()};
    attend(signals, figures, o.json, stop, ended);
    thread.join();
    if (trouble) {
        std::rethrow_exception(trouble);
    }
    print(figures, o.json);
    std::fprintf(stderr, "scribecell-rt: %s\n", text_of(end));
    return end == RunEnd::stopped ? 0 : kFailed;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"The controller of a scribing cell as a real-time process on Linux.", "scribecell-rt"};
    try {
        Options options;
        describe(app, options);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        if (options.cpu >= 0) {
            options.real_time.cpu = options.cpu;
        }
        return run(options);
    } catch (const std::invalid_argument& error) {
        std::fprintf(stderr, "scribecell-rt: %s\n", error.what());
        return kBadInput;
    } catch (const std::system_error& error) {
        std::fprintf(stderr, "scribecell-rt: %s\n", error.what());
        return kBadInput;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-rt: %s\n", error.what());
        return kFailed;
    }
}
