// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "boards/linux_rt/laser_head.hpp"
#include "boards/linux_rt/lines.hpp"

struct gpiod_chip;
struct gpiod_line;

namespace sc::linux_rt {

/// Where a name is wired: offset on the chip, and whether low means healthy or on.
struct LineWire {
    std::string name;
    unsigned offset = 0;
    bool active_low = false;
};
struct LineWiring {
    std::string chip;
    std::vector<LineWire> wires;
};
/// Reads CHIP:NAME=N,!NAME=N,… Throws std::invalid_argument that names what is wrong: a name that is none or comes
/// twice, an offset that comes twice or is no number, no estop or no interlock.
[[nodiscard]] LineWiring parse_wiring(const std::string& text);

/// Lines of a GPIO chip by libgpiod: inputs with events of both edges, outputs low (off) from the start. The kernel
/// keeps 16 events a line and drops the newest beyond them, so levels count as well (Lines).
class GpioLines final : public LinePort {
public:
    /// Throws std::system_error with what to do.
    explicit GpioLines(const LineWiring& wiring);
    ~GpioLines() override;

    [[nodiscard]] InputBits wired() const noexcept override { return wired_; }
    [[nodiscard]] InputBits levels() noexcept override;
    void edges(InputBits& fell, InputBits& rose) noexcept override;
    void write(OutputBits bits) noexcept override;
    /// The line `gate` alone, at once.
    void set_gate(bool open) noexcept;

private:
    void request(const LineWire& wire);

    gpiod_chip* chip_ = nullptr;
    std::array<gpiod_line*, kInputs> inputs_{};
    std::array<gpiod_line*, kOutputs> outputs_{};
    InputBits wired_ = 0;
    int last_ = -1;  ///< outputs as they were written last
};

/// Its gate line.
class GpioGate final : public GateLine {
public:
    explicit GpioGate(GpioLines& lines) : lines_(&lines) {}
    void set(bool open) noexcept override { lines_->set_gate(open); }

private:
    GpioLines* lines_;
};

}  // namespace sc::linux_rt
