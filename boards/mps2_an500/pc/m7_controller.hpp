// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "boards/mps2_an500/pc/instruction_stats.hpp"
#include "boards/mps2_an500/pc/qemu_process.hpp"
#include "boards/mps2_an500/pc/shared_file.hpp"
#include "boards/sim/controller_host.hpp"

namespace sc::mps2_an500 {

struct M7Options {
    std::filesystem::path image;  ///< ELF file of the core
    std::string qemu = "qemu-system-arm";
    std::chrono::milliseconds stall_timeout{20'000};  ///< no answer for so long: the core is taken for dead
};

/// The image that the preset `m7` makes: below $SCRIBECELL_ROOT, or below the nearest folder above this program that
/// has one. Throws SetupError that says how to build it.
[[nodiscard]] std::filesystem::path find_image();

/// The controller on a Cortex-M7 in QEMU, in lock-step through the board's shared RAM. One thread; the thread that
/// makes it must outlive it. A tick costs its instructions at some 200 million a second, and some microseconds.
class M7Controller final : public sim::ControllerHost {
public:
    /// Starts QEMU and waits until the core is ready. Throws SetupError when the image or QEMU is missing, the image is
    /// none or was built from other sources than this program; and what tick() throws.
    M7Controller(const M7Options& options, const MachineConfig& machine, std::uint32_t boot_id);

    /// Throws std::runtime_error when QEMU has ended, the core does not answer in time, has halted with a fault record,
    /// or could not take the inputs.
    void tick(const ServoInputs& inputs, ServoOutputs& outputs) override;
    void fit_key(const link::SealSecret& secret) override;
    [[nodiscard]] Fault first_fault() const override { return static_cast<Fault>(shared_->ram().first_fault); }
    [[nodiscard]] std::string board() const override { return "mps2_an500"; }
    [[nodiscard]] std::optional<sim::BoardFigures> figures() override;

    /// Cost of the last tick.
    [[nodiscard]] TickCost last_cost() const noexcept;
    /// What the core counts for its loops of known length, by number; loop_instructions_of() is the truth.
    [[nodiscard]] std::vector<std::uint32_t> count_loops();
    /// Makes the core execute an undefined instruction. Throws what tick() throws for a halted core.
    void provoke_fault() { ask(Request::provoke_fault); }
    /// Makes the core use up its stack. Throws likewise.
    void exhaust_stack() { ask(Request::exhaust_stack); }
    /// Of the sources of this program; the image must have the same.
    [[nodiscard]] static std::uint64_t build_id() noexcept;
    [[nodiscard]] pid_t process() const noexcept { return qemu_.id(); }

private:
    /// Sends a request and waits for its answer.
    void ask(Request request);
    void wait_until_ready();
    void check_identity() const;
    /// Throws if the core or QEMU is dead, or `since` is too long ago.
    void check_alive(std::chrono::steady_clock::time_point since);

    M7Options options_;
    std::unique_ptr<SharedFile> shared_;
    QemuProcess qemu_;
    sim::BoardFigures figures_;
};

/// For CellOptions::controller.
[[nodiscard]] sim::MakeController make_m7_controller(const M7Options& options);

}  // namespace sc::mps2_an500
