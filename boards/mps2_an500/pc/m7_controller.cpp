// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an500/pc/m7_controller.hpp"

#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <string_view>

#include <sched.h>

#include "boards/mps2_an500/build_id.hpp"
#include "firmware/recording/io_image.hpp"
#include "shared/codes/state.hpp"
#include "shared/link/config.hpp"
#include "shared/link/schema.hpp"

namespace sc::mps2_an500 {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kImage = "build/m7/bin/scribecell-mps2-an500.elf";
constexpr const char* kHowToBuild = "build it: cmake --preset m7 && cmake --build --preset m7 (./run --board m7 does)";

/// Waits ever more politely: a tick's answer comes within tens of microseconds when a core of the PC is free.
class Patience {
public:
    /// True every now and then, when it is worth to look whether the other side still lives.
    [[nodiscard]] bool wait() {
        ++count_;
        if (count_ < kSpins) {
            return false;
        }
        if (count_ < kYields) {
            ::sched_yield();
            return false;
        }
        constexpr timespec kNap{0, 50'000};
        ::nanosleep(&kNap, nullptr);
        return count_ % kLookEvery == 0;
    }

private:
    static constexpr std::uint32_t kSpins = 4000;
    static constexpr std::uint32_t kYields = 8000;
    static constexpr std::uint32_t kLookEvery = 100;
    std::uint32_t count_ = 0;
};

std::uint32_t load(std::uint32_t& word) { return std::atomic_ref(word).load(std::memory_order_acquire); }
CoreState core_state(SharedRam& ram) { return static_cast<CoreState>(load(ram.core_state)); }

std::string hex(std::uint64_t value) {
    std::array<char, 20> text{};
    std::snprintf(text.data(), text.size(), "0x%llx", static_cast<unsigned long long>(value));
    return text.data();
}

std::string halt_text(const FaultRecord& fault) {
    const std::string place = " at " + hex(fault.pc) + " (lr " + hex(fault.lr) + ", sp " + hex(fault.sp) + "): ";
    switch (static_cast<HaltCause>(fault.cause)) {
        case HaltCause::exception:
            return "the core halted with exception " + std::to_string(fault.exception) + place + "CFSR " +
                   hex(fault.cfsr) + ", HFSR " + hex(fault.hfsr) + ", BFAR " + hex(fault.bfar) +
                   "; arm-none-eabi-addr2line -e IMAGE names the line";
        case HaltCause::panic:
            return "the core's program gave up" + place + "arm-none-eabi-addr2line -e IMAGE names the line";
        case HaltCause::bad_start: return "the core does not understand this program's shared RAM: build both again";
        case HaltCause::none: break;
    }
    return "the core halted without a record";
}

/// ELF, 32 bit, little-endian, machine 40.
bool is_arm_elf(const std::filesystem::path& file) {
    std::array<char, 20> head{};
    std::ifstream(file, std::ios::binary).read(head.data(), head.size());
    const std::string_view text(head.data(), head.size());
    return text.starts_with("\177ELF\1\1") && text[18] == 40 && text[19] == 0;
}

std::filesystem::path checked(const std::filesystem::path& image) {
    if (!std::filesystem::is_regular_file(image)) {
        throw SetupError("there is no image for the Cortex-M7 at " + image.string() + "; " + kHowToBuild);
    }
    if (!is_arm_elf(image)) {
        throw SetupError(image.string() + " is no image for the Cortex-M7: no ELF file for Arm; " + kHowToBuild);
    }
    return image;
}

std::vector<std::string> qemu_arguments(const std::filesystem::path& image, const std::string& memory) {
    return {"-M",
            "mps2-an500,memory-backend=psram",
            "-object",
            "memory-backend-file,id=psram,size=" + std::to_string(kSharedRamFileBytes) + ",mem-path=" + memory +
                ",share=on",
            "-icount",
            "shift=6",
            "-kernel",
            checked(image).string(),
            "-nographic",
            "-monitor",
            "none",
            "-serial",
            "none"};
}

std::unique_ptr<SharedFile> prepared(const MachineConfig& machine, std::uint32_t boot_id) {
    auto file = std::make_unique<SharedFile>();
    SharedRam& ram = file->ram();
    link::serialise(machine, std::span(ram.config).first<link::kConfigSize>());
    ram.config_size = link::kConfigSize;
    ram.boot_id = boot_id;
    ram.pc_layout_version = kLayoutVersion;
    ram.pc_magic = kPcMagic;
    return file;
}

}  // namespace

std::filesystem::path find_image() {
    if (const char* root = std::getenv("SCRIBECELL_ROOT"); root != nullptr) {
        return checked(std::filesystem::path(root) / kImage);
    }
    std::error_code ignored;
    std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
    while (folder.has_relative_path() && !std::filesystem::exists(folder / kImage)) {
        folder = folder.parent_path();
    }
    if (!folder.has_relative_path()) {
        throw SetupError(std::string("there is no image for the Cortex-M7 (") + kImage + "); " + kHowToBuild);
    }
    return folder / kImage;
}

M7Controller::M7Controller(const M7Options& options, const MachineConfig& machine, std::uint32_t boot_id)
    : options_(options),
      shared_(prepared(machine, boot_id)),
      qemu_(options.qemu, qemu_arguments(options.image, shared_->path())) {
    wait_until_ready();
    check_identity();
    figures_.stack_used_at_start = shared_->ram().stack_used_at_start;
    figures_.stack_size = shared_->ram().stack_size;
    figures_.controller_bytes = shared_->ram().controller_bytes;
}

void M7Controller::wait_until_ready() {
    const Clock::time_point begun = Clock::now();
    for (Patience patience; core_state(shared_->ram()) != CoreState::ready;) {
        if (patience.wait()) {
            check_alive(begun);
        }
    }
}

void M7Controller::check_identity() const {
    const SharedRam& ram = shared_->ram();
    if (ram.core_magic != kCoreMagic || ram.core_layout_version != kLayoutVersion ||
        ram.schema_hash != link::kSchemaHash || ram.build_id != kBuildId) {
        throw SetupError("the image " + options_.image.string() + " (layout " +
                         std::to_string(ram.core_layout_version) + ", build " + hex(ram.build_id) +
                         ") does not belong to this program (layout " + std::to_string(kLayoutVersion) + ", build " +
                         hex(kBuildId) + "): they are of different sources; " + kHowToBuild);
    }
}

void M7Controller::check_alive(Clock::time_point since) {
    if (core_state(shared_->ram()) == CoreState::halted) {
        throw std::runtime_error(halt_text(shared_->ram().fault));
    }
    if (const auto end = qemu_.ended()) {
        throw std::runtime_error("QEMU ended by itself with " + *end +
                                 ": its message, if any, stands above; try again, and see that " +
                                 options_.image.string() + " is the image for the Cortex-M7");
    }
    if (Clock::now() - since > options_.stall_timeout) {
        throw std::runtime_error("the Cortex-M7 in QEMU has not answered for " +
                                 std::to_string(options_.stall_timeout.count()) +
                                 " ms: see that this machine is not overloaded or suspended, and try again");
    }
}

void M7Controller::ask(Request request) {
    SharedRam& ram = shared_->ram();
    ram.command = static_cast<std::uint32_t>(request);
    const std::uint32_t number = ram.request + 1;
    std::atomic_ref(ram.request).store(number, std::memory_order_release);
    const Clock::time_point begun = Clock::now();
    for (Patience patience; load(ram.done) != number;) {
        if (patience.wait()) {
            check_alive(begun);
        }
    }
    if (static_cast<Answer>(ram.answer) != Answer::done) {
        throw std::runtime_error("the Cortex-M7 refused request " + std::to_string(ram.command) + " with answer " +
                                 std::to_string(ram.answer) + ": report this");
    }
}

void M7Controller::tick(const ServoInputs& inputs, ServoOutputs& outputs) {
    SharedRam& ram = shared_->ram();
    ram.inputs_size = static_cast<std::uint32_t>(recording::pack(inputs, ram.inputs));
    ask(Request::tick);
    if (ram.outputs_size > ram.outputs.size() ||
        !recording::unpack(std::span<const std::uint8_t>(ram.outputs).first(ram.outputs_size), outputs)) {
        throw std::runtime_error("the outputs of the Cortex-M7 at tick " + std::to_string(inputs.tick) +
                                 " cannot be read: report this");
    }
    add(figures_.all, last_cost(), inputs.tick);
    if (static_cast<State>(outputs.state) == State::marking) {
        add(figures_.marking, last_cost(), inputs.tick);
    }
}

void M7Controller::fit_key(const link::SealSecret& secret) {
    shared_->ram().seal_key = secret.key;
    shared_->ram().seal_entropy = secret.entropy;
    ask(Request::fit_key);
}

std::uint64_t M7Controller::build_id() noexcept { return kBuildId; }

TickCost M7Controller::last_cost() const noexcept {
    return {shared_->ram().servo_instructions, shared_->ram().plan_instructions};
}

std::optional<sim::BoardFigures> M7Controller::figures() {
    ask(Request::measure_stack);
    figures_.stack_used = shared_->ram().stack_used;
    return figures_;
}

std::vector<std::uint32_t> M7Controller::count_loops() {
    ask(Request::count_loops);
    const auto& counted = shared_->ram().loop_instructions;
    return {counted.begin(), counted.end()};
}

sim::MakeController make_m7_controller(const M7Options& options) {
    // What the board retains lies in its own memory.
    return [options](const MachineConfig& machine, std::uint32_t boot_id, RetainedMemory* /*retained*/) {
        return std::make_unique<M7Controller>(options, machine, boot_id);
    };
}

}  // namespace sc::mps2_an500
