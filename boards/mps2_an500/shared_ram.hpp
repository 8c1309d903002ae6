// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "firmware/recording/io_image.hpp"
#include "shared/link/config.hpp"

/// What the core and the PC see of each other: the start of the board's 16 MB PSRAM, which is a file shared with the
/// PC. Fields of fixed width, little-endian on both sides. `request` and `done` are read and written atomically with
/// acquire and release; everything else belongs to the PC while they are equal and to the core while they differ.

namespace sc::mps2_an500 {

inline constexpr std::uintptr_t kSharedRamAddress = 0x6000'0000;
inline constexpr std::size_t kSharedRamFileBytes = std::size_t{16} << 20U;

/// The PC's "SCPC" and the core's "SCM7". Without the first the core runs free, with its link on UART0.
inline constexpr std::uint32_t kPcMagic = 0x4350'4353;
inline constexpr std::uint32_t kCoreMagic = 0x374D'4353;
inline constexpr std::uint32_t kLayoutVersion = 5;

/// How far the core is. `halted` is final: the fault record says why.
enum class CoreState : std::uint32_t { starting = 0, ready = 1, halted = 2 };

enum class Request : std::uint32_t {
    tick = 1,           ///< unpack inputs, servo_step, plan_step, pack outputs
    measure_stack = 2,  ///< fill in stack_used
    count_loops = 3,    ///< fill in loop_instructions: the counter tried on loops of known length
    provoke_fault = 4,  ///< execute an undefined instruction, so that a test sees the fault record
    exhaust_stack = 5,  ///< call itself without end, for the same
    fit_key = 6,        ///< take the key: before the first tick
};
enum class Answer : std::uint32_t { none = 0, done = 1, bad_inputs = 2, bad_outputs = 3, bad_request = 4 };

/// Why the core has halted.
enum class HaltCause : std::uint32_t {
    none = 0,
    exception = 1,  ///< of the core: `exception` is its number (3 hard, 4 memory, 5 bus, 6 usage, 16 + n interrupt)
    panic = 2,      ///< the program itself: abort(), a pure virtual call
    bad_start = 3,  ///< layout or machine of the PC not understood
};
struct FaultRecord {
    std::uint32_t cause = 0;  ///< HaltCause
    std::uint32_t exception = 0;
    std::uint32_t pc = 0;  ///< where it happened; 0 when the stack could not be read
    std::uint32_t lr = 0;
    std::uint32_t xpsr = 0;
    std::uint32_t sp = 0;
    std::uint32_t cfsr = 0;  ///< configurable fault status
    std::uint32_t hfsr = 0;
    std::uint32_t mmfar = 0;
    std::uint32_t bfar = 0;
};

/// The loops of count_loops: loop i is run through loop_passes(i) times and executes loop_instructions_of(i)
/// instructions.
inline constexpr std::size_t kLoops = 64;
constexpr std::uint32_t loop_passes(std::size_t i) noexcept {
    return static_cast<std::uint32_t>(i < 48 ? i + 1 : (i - 47) * (i - 47) * 4001);
}
constexpr std::uint32_t loop_instructions_of(std::size_t i) noexcept { return 2 + 2 * loop_passes(i); }

struct SharedRam {
    // The PC's, before the core starts.
    std::uint32_t pc_magic = 0;
    std::uint32_t pc_layout_version = 0;
    std::uint32_t boot_id = 0;
    std::uint32_t config_size = 0;
    std::array<std::uint8_t, 1264> config{};  ///< link::serialise of the machine

    // The core's, before it is `ready`.
    std::uint32_t core_magic = 0;
    std::uint32_t core_layout_version = 0;
    std::uint64_t schema_hash = 0;  ///< of the link
    std::uint64_t build_id = 0;     ///< of the sources
    std::uint32_t controller_bytes = 0;
    std::uint32_t core_state = 0;           ///< CoreState, atomic
    std::uint32_t stack_size = 0;           ///< bytes
    std::uint32_t stack_used_at_start = 0;  ///< bytes touched until `ready`
    std::uint32_t stack_used = 0;           ///< bytes touched since, as of the last measure_stack
    FaultRecord fault;
    std::uint32_t unused = 0;

    // Lock-step.
    std::uint32_t request = 0;  ///< atomic; the PC adds one
    std::uint32_t command = 0;  ///< Request
    std::uint32_t done = 0;     ///< atomic; the core makes it equal to request
    std::uint32_t answer = 0;   ///< Answer
    std::uint32_t inputs_size = 0;
    std::uint32_t outputs_size = 0;
    std::uint32_t servo_instructions = 0;  ///< of the last tick, without packing
    std::uint32_t plan_instructions = 0;
    std::uint32_t first_fault = 0;
    std::array<std::uint32_t, kLoops> loop_instructions{};
    std::array<std::uint8_t, 16> seal_key{};
    std::array<std::uint8_t, 16> seal_entropy{};
    std::array<std::uint8_t, (recording::kInputsImageCapacity + 7) / 8 * 8> inputs{};
    std::array<std::uint8_t, (recording::kOutputsImageCapacity + 7) / 8 * 8> outputs{};
};

static_assert(sizeof(SharedRam::config) >= link::kConfigSize);
static_assert(std::is_trivially_copyable_v<SharedRam> && std::is_standard_layout_v<SharedRam>);
static_assert(offsetof(SharedRam, core_magic) == 1280 && offsetof(SharedRam, schema_hash) == 1288 &&
              offsetof(SharedRam, request) == 1368 && offsetof(SharedRam, inputs) == 1368 + 36 + 4 * kLoops + 32);
static_assert(sizeof(SharedRam) <= kSharedRamFileBytes);

}  // namespace sc::mps2_an500
