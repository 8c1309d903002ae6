// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

/// The bus of the chip as drivers see it, on a PC: peripherals at addresses, memory that DMA reaches, interrupt lines
/// and virtual time. What a driver does in an order or at a time that the chip does not allow is noted by the
/// peripheral as a violation; a test of a driver ends with `violations()` empty. Knows nothing of the drivers:
/// addresses, bits and orders come from tests/data/stm32h743 (see its README for the source).

namespace sc::model {

class Machine;

class Peripheral {
public:
    static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

    Peripheral() = default;
    Peripheral(const Peripheral&) = delete;
    Peripheral& operator=(const Peripheral&) = delete;
    virtual ~Peripheral() = default;

    [[nodiscard]] virtual std::uint32_t read(std::uint32_t offset) = 0;
    /// `bytes`: 1, 2 or 4 of an access at `offset`.
    virtual void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) = 0;
    /// When it acts next by itself, on the machine's clock in ns.
    [[nodiscard]] virtual std::int64_t next_ns() const { return kNever; }
    /// Called at next_ns().
    virtual void act(std::int64_t /*now_ns*/) {}
    /// What it does by itself changes nothing of when another acts, but by an interrupt.
    [[nodiscard]] virtual bool minds_its_own() const { return false; }
};

/// One at a time: constructing it puts it in force, its end takes it out.
class Machine {
public:
    Machine();
    Machine(const Machine&) = delete;
    Machine& operator=(const Machine&) = delete;
    ~Machine();

    static Machine& in_force();

    void attach(std::uint32_t base, std::uint32_t size, Peripheral& peripheral);
    /// Memory of the chip that this object stands for. An object outside all of these has no address: a violation.
    void map_memory(std::uint32_t base, std::span<std::uint8_t> memory);

    [[nodiscard]] std::uint32_t read(std::uint32_t at);
    void write(std::uint32_t at, std::uint32_t value, unsigned bytes);
    [[nodiscard]] std::uint32_t address_of(const void* object);
    /// As DMA reads and writes: memory or a peripheral. `bytes` 1, 2 or 4.
    [[nodiscard]] std::uint32_t bus_read(std::uint32_t at, unsigned bytes);
    void bus_write(std::uint32_t at, std::uint32_t value, unsigned bytes);

    /// Each reading of a register takes so long, so that waits end; 10 ns unless told.
    void set_access_ns(std::int64_t ns) { access_ns_ = ns; }
    [[nodiscard]] std::int64_t now_ns() const { return now_ns_; }
    /// Peripherals act in the order of time, then of attachment; interrupts are served between.
    void advance_to(std::int64_t ns);

    /// `number` as in the vector table, from 0 after the system exceptions.
    void on_interrupt(unsigned number, std::function<void()> handler);
    void raise(unsigned number);

    void violation(const std::string& what);
    [[nodiscard]] const std::vector<std::string>& violations() const { return violations_; }
    /// All of them, one a line.
    [[nodiscard]] std::string violations_text() const;

private:
    struct Region {
        std::uint32_t base = 0;
        std::uint32_t size = 0;
        Peripheral* peripheral = nullptr;
        std::uint8_t* memory = nullptr;
    };
    [[nodiscard]] const Region* find(std::uint32_t at, unsigned bytes) const;
    void serve();

    struct Turn {
        Peripheral* first = nullptr;
        std::int64_t ns = Peripheral::kNever;
        std::int64_t others_ns = Peripheral::kNever;
    };
    [[nodiscard]] Turn next_turn() const;

    std::vector<Region> regions_;
    mutable std::size_t last_found_ = 0;
    std::map<unsigned, std::function<void()>> handlers_;
    std::vector<unsigned> raised_;
    std::vector<std::string> violations_;
    std::int64_t now_ns_ = 0;
    std::int64_t access_ns_ = 10;
    bool serving_ = false;
    bool advancing_ = false;
};

}  // namespace sc::model
