// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/parameter_file.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "firmware/store/parameter_store.hpp"
#include "shared/link/config.hpp"

namespace sc::sim {
namespace {

constexpr int kEraseTicks = 20;
constexpr int kWriteTicks = 1;

}  // namespace

ParameterFile::ParameterFile(std::filesystem::path path) : path_(std::move(path)) {
    for (auto& slot : slots_) {
        slot.fill(0xFF);
    }
    if (path_.empty()) {
        return;
    }
    if (path_.has_parent_path()) {
        std::filesystem::create_directories(path_.parent_path());
    }
    if (!std::filesystem::exists(path_)) {
        for (std::size_t slot = 0; slot < kSlots; ++slot) {
            std::ofstream(path_, std::ios::binary | std::ios::app)
                .write(reinterpret_cast<const char*>(slots_.at(slot).data()), kSlotBytes);
        }
    }
    std::ifstream in(path_, std::ios::binary);
    for (auto& slot : slots_) {
        in.read(reinterpret_cast<char*>(slot.data()), kSlotBytes);
    }
    if (!in) {
        throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(), path_.string());
    }
}

void ParameterFile::erase(std::size_t slot) noexcept {
    slots_.at(slot).fill(0xFF);
    keep(slot * kSlotBytes, slots_.at(slot));
    waits_ = kEraseTicks;
}

void ParameterFile::write(std::size_t slot, std::size_t unit, const Unit& bytes) noexcept {
    std::ranges::copy(bytes, slots_.at(slot).begin() + static_cast<std::ptrdiff_t>(unit * kUnit));
    keep(slot * kSlotBytes + unit * kUnit, bytes);
    waits_ = kWriteTicks;
}

void ParameterFile::keep(std::size_t offset, std::span<const std::uint8_t> bytes) noexcept {
    if (path_.empty()) {
        return;
    }
    std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(offset));
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

StartingMachine starting_machine(const ParameterMemory& memory, const MachineConfig& built_in) {
    const auto stored = store::newest(memory);
    MachineConfig machine;
    if (!stored || stored->layout != link::kConfigVersion ||
        link::deserialise_into(machine, stored->bytes) != Refusal::none) {
        return {built_in, 0};
    }
    return {machine, stored->generation};
}

}  // namespace sc::sim
