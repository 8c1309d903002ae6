// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "boards/event_device/event_link.hpp"
#include "firmware/hal/io.hpp"

namespace sc::linux_rt {

/// Fixed optics in the place of a scan head. This board has no XY2-100 line; the controller asks any head for a proof
/// that its mirrors move, and these are by construction where they are sent: at once, and telling so. The machine's
/// field is nought (MachineConfig::galvo.half_field), so no job can make use of them.
class FixedOptics {
public:
    /// Status word at the start of a tick, whose last window was played by `play`.
    [[nodiscard]] std::uint16_t status() const noexcept { return status_; }
    /// The frames that act in the window that ends at the next tick.
    void play(const ServoOutputs& acting) noexcept;

private:
    std::uint16_t status_ = kGalvoStatusOk;
};

/// The laser with its source and shutter, as the control loop sees them.
class LaserHead {
public:
    LaserHead() = default;
    LaserHead(const LaserHead&) = delete;
    LaserHead& operator=(const LaserHead&) = delete;
    virtual ~LaserHead() = default;

    /// Inputs at t_tick. `digital` holds the board's own lines and is completed with those that the head has.
    virtual void sample(std::int64_t tick, DigitalInputs& digital) noexcept = 0;
    /// Outputs of tick n, at once after its step.
    virtual void accept(std::int64_t tick, const ServoOutputs& outputs) noexcept = 0;
    /// The guard's word between ticks: not 0 shuts the gate now.
    virtual void veto(std::uint8_t causes) noexcept = 0;
    /// Bytes of the source's serial port that came with the last sample.
    [[nodiscard]] virtual std::span<const std::uint8_t> source_rx() const noexcept { return {}; }
    /// Whether the window of the last tick has been played (a head that tells); does not wait.
    [[nodiscard]] virtual bool settled() noexcept { return true; }
    /// Gone for good.
    [[nodiscard]] virtual bool lost() const noexcept { return false; }
};

/// No laser: axes and sensors alone. The controller refuses to arm (the source is not ready).
class NoLaser final : public LaserHead {
public:
    void sample(std::int64_t /*tick*/, DigitalInputs& digital) noexcept override;
    void accept(std::int64_t tick, const ServoOutputs& outputs) noexcept override;
    void veto(std::uint8_t /*causes*/) noexcept override {}

private:
    bool open_ = false;
};

/// The laser behind an event device (boards/event_device).
class EventHead final : public LaserHead {
public:
    explicit EventHead(event_device::EventLink& link) : link_(&link) {}
    void sample(std::int64_t tick, DigitalInputs& digital) noexcept override;
    void accept(std::int64_t tick, const ServoOutputs& outputs) noexcept override {
        link_->send(tick, outputs);
        sent_tick_ = tick;
    }
    void veto(std::uint8_t causes) noexcept override;
    [[nodiscard]] std::span<const std::uint8_t> source_rx() const noexcept override {
        return std::span(status_.source).first(status_.source_size);
    }
    [[nodiscard]] bool settled() noexcept override;
    [[nodiscard]] bool lost() const noexcept override { return link_->lost(); }

private:
    void hear() noexcept;

    event_device::EventLink* link_;
    event_device::Status status_;
    std::int64_t heard_tick_ = -1;
    bool fresh_ = false;
    std::int64_t sent_tick_ = -1;
    std::uint8_t causes_ = 0;
};

/// A digital output that lets the source emit.
class GateLine {
public:
    GateLine() = default;
    GateLine(const GateLine&) = delete;
    GateLine& operator=(const GateLine&) = delete;
    virtual ~GateLine() = default;
    virtual void set(bool open) noexcept = 0;
};

/// The laser gated by a line of this board: open for each tick's window in which the path has pulses. Where a mark
/// begins and ends is off by as much as the path's speed makes of a tick, and pulses within it are the source's own.
/// What the machine then promises: restrict_to_gate.
class GatedHead final : public LaserHead {
public:
    explicit GatedHead(GateLine& line) : line_(&line) {}
    void sample(std::int64_t tick, DigitalInputs& digital) noexcept override;
    void accept(std::int64_t tick, const ServoOutputs& outputs) noexcept override;
    void veto(std::uint8_t causes) noexcept override;

private:
    GateLine* line_;
    bool next_ = false;  ///< for the window that begins at the next tick
    bool vetoed_ = false;
};

/// What a machine with a bare gate line can do: one pulse a tick at most. So a job whose pitch is finer than its speed
/// times a tick, which is the error of a place, asks for a rate above the source's, and is refused by the host's check
/// and by the controller's own (Refusal::bad_pitch).
void restrict_to_gate(MachineConfig& machine) noexcept;
/// This board has no scan head: the field is nought, and nothing follows by mirrors.
void restrict_to_axes(MachineConfig& machine) noexcept;

}  // namespace sc::linux_rt
