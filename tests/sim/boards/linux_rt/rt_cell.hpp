// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include <sys/socket.h>
#include <unistd.h>

#include "boards/event_device/event_packets.hpp"
#include "boards/linux_rt/allocation_watch.hpp"
#include "boards/linux_rt/control_loop.hpp"
#include "boards/sim/events/event_player.hpp"
#include "boards/sim/plant/cell_plant.hpp"
#include "boards/sim/plant/drive.hpp"
#include "boards/sim/world/world_spec.hpp"
#include "boards/socketcan/can_socket.hpp"
#include "shared/link/can_port.hpp"

namespace sc::linux_rt {

/// Both ends of a socket that carries packets, as CAN interfaces and event devices do.
inline std::array<int, 2> packet_pair() {
    std::array<int, 2> files{};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, files.data()) != 0) {
        throw std::runtime_error("no socket pair");
    }
    return files;
}

/// Drives of the simulated cell on a bus that is a socket pair.
class BusOfDrives {
public:
    BusOfDrives(const MachineConfig& machine, const sim::WorldSpec& world, int socket)
        : bus_(socket), period_ns_(machine.control_period_ns) {
        for (std::size_t i = 0; i < kAxisCount; ++i) {
            sim::SimDriveOptions options = sim::drive_options(
                machine.axis[i], machine.drive_cycle_ticks * machine.control_period_ns, sim::kPowerUpPosition[i]);
            options.backlash = world.drives.backlash[i];
            options.servo.disturbance = world.drives.disturbance[i];
            options.servo.disturbance_frequency = world.drives.disturbance_frequency;
            drives_.emplace_back(options);
        }
    }
    /// Lives from t_tick to t_tick+1 with the frames that are on the bus.
    void play(std::int64_t tick) {
        const std::int64_t begin = tick * period_ns_;
        socketcan::CanFrame heard;
        while (bus_.receive(heard)) {
            DriveFrame frame{.id = static_cast<std::uint16_t>(heard.id), .size = heard.size};
            std::copy_n(heard.data.begin(), frame.data.size(), frame.data.begin());
            for (sim::SimDrive& drive : drives_) {
                drive.receive(frame, begin);
            }
        }
        std::vector<DriveFrame> sent;
        for (sim::SimDrive& drive : drives_) {
            for (std::int64_t t = begin + 100'000; t <= begin + period_ns_; t += 100'000) {
                drive.step_to(t);
            }
            drive.drain(sent);
        }
        for (const DriveFrame& frame : sent) {
            socketcan::CanFrame raw;
            raw.id = frame.id;
            raw.size = frame.size;
            std::copy(frame.data.begin(), frame.data.end(), raw.data.begin());
            (void)bus_.send(raw);
        }
    }
    [[nodiscard]] sim::SimDrive& drive(std::size_t i) { return drives_.at(i); }

private:
    socketcan::CanSocket bus_;
    std::int64_t period_ns_;
    std::vector<sim::SimDrive> drives_;
};

/// Lines that a test moves.
class HandLines final : public LinePort {
public:
    [[nodiscard]] InputBits wired() const noexcept override { return level; }
    [[nodiscard]] InputBits levels() noexcept override { return level; }
    void edges(InputBits& fell_now, InputBits& rose_now) noexcept override {
        fell_now = std::exchange(fell, InputBits{0});
        rose_now = 0;
    }
    void write(OutputBits bits) noexcept override { outputs = bits; }

    InputBits level = static_cast<InputBits>(bit(Input::estop) | bit(Input::interlock) | bit(Input::key_production));
    InputBits fell = 0;
    OutputBits outputs = 0;
};

/// The control loop of the Linux board with drives, event device and host on socket pairs, in virtual time: what the
/// simulated cell is, by the board's own way.
class RtCell {
public:
    explicit RtCell(const sim::WorldSpec& world, bool fd = false, MachineConfig machine = axes_machine())
        : machine_(machine),
          drive_files_(packet_pair()),
          link_files_(packet_pair()),
          event_files_(packet_pair()),
          drives_(make_buses(drive_files_[0])),
          bus_(machine_, world, drive_files_[1]),
          link_(socketcan::CanSocket(link_files_[0]), fd, "test"),
          host_(link_files_[1]),
          host_port_(link::kCanIdToController, fd),
          events_(event_files_[0], machine_),
          head_(events_),
          player_(machine_, [this](std::int64_t, std::string_view what, std::int64_t) { pulses += what == "pulse"; }),
          packet_(event_device::kPacketCapacity),
          window_(std::make_unique<ServoOutputs>()),
          loop_(std::make_unique<ControlLoop>(machine_, 1, nullptr, LoopParts{&drives_, &link_, &lines, &head_, {}})) {}
    RtCell(const RtCell&) = delete;
    RtCell& operator=(const RtCell&) = delete;
    ~RtCell() { hang_up_events(); }

    static MachineConfig axes_machine() {
        MachineConfig machine = reference_machine();
        restrict_to_axes(machine);
        return machine;
    }

    void push_link(std::span<const std::uint8_t> bytes) {
        (void)host_port_.push(bytes);
        link::LinkCanFrame frame;
        while (host_port_.next(frame)) {
            socketcan::CanFrame raw;
            raw.id = frame.id;
            raw.fd = raw.fast = frame.fd;
            raw.size = frame.size;
            raw.data = frame.data;
            (void)host_.send(raw);
        }
    }
    std::size_t take_link(std::vector<std::uint8_t>& out) {
        socketcan::CanFrame heard;
        std::array<std::uint8_t, link::kSerialCapacity> message{};
        const std::size_t before = out.size();
        while (host_.receive(heard)) {
            const std::size_t n =
                host_port_.take({.id = heard.id, .size = heard.size, .data = heard.data, .fd = heard.fd}, message);
            out.insert(out.end(), message.begin(), message.begin() + static_cast<std::ptrdiff_t>(n));
        }
        return out.size() - before;
    }
    void tick() {
        const std::int64_t tick = loop_->next_tick();
        if (watch_allocations) {
            const NoAllocation watched;
            loop_->tick();
        } else {
            loop_->tick();
        }
        if (play_drives) {
            bus_.play(tick);
        }
        play_events();
    }
    [[nodiscard]] std::int64_t now_ns() const { return loop_->next_tick() * machine_.control_period_ns; }
    [[nodiscard]] State state() const { return static_cast<State>(loop_->latest().state); }
    [[nodiscard]] std::uint64_t faults() const { return loop_->latest().faults; }
    [[nodiscard]] ControlLoop& loop() { return *loop_; }
    [[nodiscard]] DriveBus& drives() { return drives_; }
    [[nodiscard]] BusOfDrives& bus() { return bus_; }
    [[nodiscard]] sim::EventPlayer& player() { return player_; }
    [[nodiscard]] const event_device::EventLink& events() const { return events_; }
    void hang_up_events() {
        if (event_files_[1] >= 0) {
            ::close(event_files_[1]);
            event_files_[1] = -1;
        }
    }

    HandLines lines;
    bool play_drives = true;
    bool watch_allocations = false;
    std::uint64_t pulses = 0;

private:
    static std::vector<socketcan::CanSocket> make_buses(int file) {
        std::vector<socketcan::CanSocket> buses;
        buses.emplace_back(file);
        return buses;
    }
    void play_events() {
        while (event_files_[1] >= 0) {
            const ssize_t n = ::recv(event_files_[1], packet_.data(), packet_.size(), MSG_DONTWAIT);
            if (n <= 0) {
                return;
            }
            const auto bytes = std::span<const std::uint8_t>(packet_).first(static_cast<std::size_t>(n));
            std::int64_t tick = 0;
            std::uint8_t causes = 0;
            if (event_device::get_veto(bytes, causes)) {
                player_.veto(causes);
            } else if (event_device::get_window(bytes, tick, *window_)) {
                player_.window(tick, *window_);
                std::array<std::uint8_t, event_device::kStatusCapacity> reply{};
                const std::size_t size = event_device::put_status(player_.status(), reply);
                (void)::send(event_files_[1], reply.data(), size, MSG_NOSIGNAL);
            }
        }
    }

    MachineConfig machine_;
    std::array<int, 2> drive_files_;
    std::array<int, 2> link_files_;
    std::array<int, 2> event_files_;
    DriveBus drives_;
    BusOfDrives bus_;
    CanLink link_;
    socketcan::CanSocket host_;
    link::CanPort<8192> host_port_;
    event_device::EventLink events_;
    EventHead head_;
    sim::EventPlayer player_;
    std::vector<std::uint8_t> packet_;
    std::unique_ptr<ServoOutputs> window_;
    std::unique_ptr<ControlLoop> loop_;
};

}  // namespace sc::linux_rt
