// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/machine.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "boards/stm32h743/registers/access.hpp"

namespace sc::model {
namespace {

Machine* current = nullptr;

std::string hex(std::uint32_t value) {
    char text[16];
    (void)std::snprintf(text, sizeof text, "0x%08X", value);
    return text;
}

}  // namespace

Machine::Machine() {
    if (current != nullptr) {
        throw std::logic_error("a machine is in force already");
    }
    current = this;
}

Machine::~Machine() { current = nullptr; }

Machine& Machine::in_force() {
    if (current == nullptr) {
        throw std::logic_error("a register is used without a machine");
    }
    return *current;
}

void Machine::attach(std::uint32_t base, std::uint32_t size, Peripheral& peripheral) {
    regions_.push_back({base, size, &peripheral, nullptr});
}

void Machine::map_memory(std::uint32_t base, std::span<std::uint8_t> memory) {
    regions_.push_back({base, static_cast<std::uint32_t>(memory.size()), nullptr, memory.data()});
}

const Machine::Region* Machine::find(std::uint32_t at, unsigned bytes) const {
    const auto holds = [&](const Region& r) { return at >= r.base && at - r.base + bytes <= r.size; };
    if (last_found_ < regions_.size() && holds(regions_[last_found_])) {
        return &regions_[last_found_];
    }
    const auto found = std::ranges::find_if(regions_, holds);
    if (found == regions_.end()) {
        return nullptr;
    }
    last_found_ = static_cast<std::size_t>(found - regions_.begin());
    return &*found;
}

std::uint32_t Machine::read(std::uint32_t at) {
    advance_to(now_ns_ + access_ns_);
    return bus_read(at, 4);
}

void Machine::write(std::uint32_t at, std::uint32_t value, unsigned bytes) {
    bus_write(at, value, bytes);
    serve();
}

std::uint32_t Machine::bus_read(std::uint32_t at, unsigned bytes) {
    const Region* region = find(at, bytes);
    if (region == nullptr || at % bytes != 0) {
        violation("read of " + std::to_string(bytes) + " bytes at " + hex(at) + ": nothing is there");
        return 0;
    }
    if (region->peripheral != nullptr) {
        return region->peripheral->read(at - region->base);
    }
    std::uint32_t value = 0;
    for (unsigned i = 0; i < bytes; ++i) {
        value |= std::uint32_t{region->memory[at - region->base + i]} << (8U * i);
    }
    return value;
}

void Machine::bus_write(std::uint32_t at, std::uint32_t value, unsigned bytes) {
    const Region* region = find(at, bytes);
    if (region == nullptr || at % bytes != 0) {
        violation("write of " + hex(value) + ", " + std::to_string(bytes) + " bytes, at " + hex(at) +
                  ": nothing is there");
        return;
    }
    if (region->peripheral != nullptr) {
        region->peripheral->write(at - region->base, value, bytes);
        return;
    }
    for (unsigned i = 0; i < bytes; ++i) {
        region->memory[at - region->base + i] = static_cast<std::uint8_t>(value >> (8U * i));
    }
}

std::uint32_t Machine::address_of(const void* object) {
    const auto* byte = static_cast<const std::uint8_t*>(object);
    for (const Region& region : regions_) {
        if (region.memory != nullptr && !std::less<>{}(byte, region.memory) &&
            std::less<>{}(byte, region.memory + region.size)) {
            return region.base + static_cast<std::uint32_t>(byte - region.memory);
        }
    }
    violation("an object that hardware shall read lies in no memory of the chip");
    return 0;
}

Machine::Turn Machine::next_turn() const {
    Turn turn;
    for (const Region& region : regions_) {
        if (region.peripheral == nullptr) {
            continue;
        }
        const std::int64_t when = region.peripheral->next_ns();
        if (when < turn.ns) {
            turn.others_ns = turn.ns;
            turn.first = region.peripheral;
            turn.ns = when;
        } else {
            turn.others_ns = std::min(turn.others_ns, when);
        }
    }
    return turn;
}

void Machine::advance_to(std::int64_t ns) {
    if (advancing_) {
        return;  // a handler that reads registers: time goes on when it has ended
    }
    advancing_ = true;
    while (true) {
        Turn turn = next_turn();
        if (turn.first == nullptr || turn.ns > ns) {
            break;
        }
        do {
            now_ns_ = std::max(now_ns_, turn.ns);
            turn.first->act(now_ns_);
            turn.ns = turn.first->next_ns();
        } while (turn.first->minds_its_own() && raised_.empty() && turn.ns < turn.others_ns && turn.ns <= ns);
        serve();
    }
    now_ns_ = std::max(now_ns_, ns);
    advancing_ = false;
}

void Machine::on_interrupt(unsigned number, std::function<void()> handler) { handlers_[number] = std::move(handler); }

void Machine::raise(unsigned number) {
    if (std::ranges::find(raised_, number) == raised_.end()) {
        raised_.push_back(number);
    }
}

/// One after the other; which may break into which is not modelled.
void Machine::serve() {
    if (serving_) {
        return;
    }
    serving_ = true;
    while (!raised_.empty()) {
        const unsigned number = raised_.front();
        raised_.erase(raised_.begin());
        if (const auto handler = handlers_.find(number); handler != handlers_.end()) {
            handler->second();
        }
    }
    serving_ = false;
}

void Machine::violation(const std::string& what) { violations_.push_back(what); }

std::string Machine::violations_text() const {
    std::string text;
    for (const std::string& one : violations_) {
        text += one + "\n";
    }
    return text;
}

}  // namespace sc::model

namespace sc::stm32h743 {

std::uint32_t read32(Address at) noexcept { return model::Machine::in_force().read(at); }
void write32(Address at, std::uint32_t value) noexcept { model::Machine::in_force().write(at, value, 4); }
void write16(Address at, std::uint16_t value) noexcept { model::Machine::in_force().write(at, value, 2); }
void write8(Address at, std::uint8_t value) noexcept { model::Machine::in_force().write(at, value, 1); }
Address address_of(const volatile void* object) noexcept {
    return model::Machine::in_force().address_of(const_cast<const void*>(object));
}
void barrier() noexcept {}
void instruction_barrier() noexcept {}

}  // namespace sc::stm32h743
