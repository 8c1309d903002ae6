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
RetainedMemory retained;  // as on a board with a battery, so that its cost is counted
// Made at the start: as initialised data they would take as much flash as RAM.
alignas(ServoOutputs) std::array<std::byte, sizeof(ServoOutputs)> outputs_memory;
alignas(Controller) std::array<std::byte, sizeof(Controller)> controller_memory;

Controller& make_controller(std::uint32_t boot_id) noexcept {
    return *::new (controller_memory.data()) Controller(machine, boot_id, &retained);
}

ServoOutputs& make_outputs() noexcept { return *::new (outputs_memory.data()) ServoOutputs{}; }

/// The PC's machine; without an understandable one nothing may run.
void read_machine(const SharedRam& ram) noexcept {
    const bool fits = ram.pc_layout_version == kLayoutVersion && ram.config_size <= ram.config.size();
    if (link::deserialise_into(machine, std::span(ram.config).first(fits ? ram.config_size : 0)) != Refusal::none) {
        halt(FaultRecord{.cause = static_cast<std::uint32_t>(HaltCause::bad_start)});
    }
}

}  // namespace

/// After the start-up code; a pedantic compiler lets nobody call `main`.
extern "C" [[noreturn]] void board_main() {
    SharedRam& ram = shared_ram();
    write_identity(ram);
    if (ram.pc_magic != kPcMagic) {
        ::new (&machine) MachineConfig(reference_machine());
        run_free(make_controller(1), make_outputs(), machine.control_period_ns);
    }
    read_machine(ram);
    serve_lock_step(make_controller(ram.boot_id), make_outputs());
}
