// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstddef>
#include <new>

#include "boards/mps2_an500/image/board_ram.hpp"
#include "boards/mps2_an500/image/fault.hpp"
#include "boards/mps2_an500/image/free_run.hpp"
#include "boards/mps2_an500/image/identity.hpp"
#include "boards/mps2_an500/image/lock_step.hpp"

namespace {

using namespace sc;
using namespace sc::mps2_an500;

MachineConfig machine;
ServoOutputs outputs;
RetainedMemory retained;  // as on a board with a battery, so that its cost is counted
alignas(Controller) std::array<std::byte, sizeof(Controller)> controller_memory;

Controller& make_controller(std::uint32_t boot_id) noexcept {
    return *::new (controller_memory.data()) Controller(machine, boot_id, &retained);
}

/// The PC's machine; without an understandable one nothing may run.
MachineConfig machine_of(const SharedRam& ram) noexcept {
    const bool fits = ram.pc_layout_version == kLayoutVersion && ram.config_size <= ram.config.size();
    const auto config = link::deserialise(std::span(ram.config).first(fits ? ram.config_size : 0));
    if (!config) {
        halt(FaultRecord{.cause = static_cast<std::uint32_t>(HaltCause::bad_start)});
    }
    return *config;
}

}  // namespace

/// After the start-up code; a pedantic compiler lets nobody call `main`.
extern "C" [[noreturn]] void board_main() {
    SharedRam& ram = shared_ram();
    write_identity(ram);
    if (ram.pc_magic != kPcMagic) {
        machine = reference_machine();
        run_free(make_controller(1), outputs, machine.control_period_ns);
    }
    machine = machine_of(ram);
    serve_lock_step(make_controller(ram.boot_id), outputs);
}
