// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/stm32h743/model/clock_tree.hpp"

/// The independent and the window watchdog of one chip. A reset is noted with its time and its cause in RCC_RSR, and
/// after it nothing counts any more. Numbers: tests/data/stm32h743/watchdog.csv.

namespace sc::model {

namespace watchdog_fields {

inline constexpr std::uint32_t kIwdg = 0x58004800;
inline constexpr std::uint32_t kWwdg = 0x50003000;
inline constexpr Field kKey{"IWDG_KR", "KEY", kIwdg + 0x00, 0, 16};
inline constexpr Field kPrescaler{"IWDG_PR", "PR", kIwdg + 0x04, 0, 3};
inline constexpr Field kReload{"IWDG_RLR", "RL", kIwdg + 0x08, 0, 12};
inline constexpr Field kPvu{"IWDG_SR", "PVU", kIwdg + 0x0C, 0, 1};
inline constexpr Field kRvu{"IWDG_SR", "RVU", kIwdg + 0x0C, 1, 1};
inline constexpr Field kCounter{"WWDG_CR", "T", kWwdg + 0x00, 0, 7};
inline constexpr Field kActive{"WWDG_CR", "WDGA", kWwdg + 0x00, 7, 1};
inline constexpr Field kWindow{"WWDG_CFR", "W", kWwdg + 0x04, 0, 7};
inline constexpr Field kEarly{"WWDG_CFR", "EWI", kWwdg + 0x04, 9, 1};
inline constexpr Field kTimeBase{"WWDG_CFR", "WDGTB", kWwdg + 0x04, 11, 3};
inline constexpr Field kEarlyFlag{"WWDG_SR", "EWIF", kWwdg + 0x08, 0, 1};
inline constexpr std::array kAll{kKey,    kPrescaler, kReload, kPvu,      kRvu,      kCounter,
                                 kActive, kWindow,    kEarly,  kTimeBase, kEarlyFlag};

}  // namespace watchdog_fields

struct WatchdogReset {
    std::string why;
    std::int64_t ns;
};

class WatchdogPair {
public:
    static constexpr unsigned kWarningInterrupt = 0;

    WatchdogPair(Machine& machine, ClockTree& tree, double lsi_hz);
    /// LSI is dead from now on.
    void stop_lsi() { lsi_runs_ = false; }
    [[nodiscard]] const std::vector<WatchdogReset>& resets() const { return resets_; }

private:
    class Independent : public Peripheral {
    public:
        explicit Independent(WatchdogPair& pair) : pair_(pair) {}
        [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
        void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
        [[nodiscard]] std::int64_t next_ns() const override { return bites_at_; }
        void act(std::int64_t now_ns) override {
            pair_.reset("independent: not fed", now_ns, clock_fields::kIwdgReset);
        }
        void silence() { bites_at_ = kNever; }

    private:
        void settle();
        void load();
        WatchdogPair& pair_;
        std::int64_t bites_at_ = kNever;
        std::int64_t prescaler_at_ = 0;  ///< its update has ended
        std::int64_t reload_at_ = 0;
        std::uint32_t prescaler_ = 0;
        std::uint32_t reload_ = 4095;
        std::uint32_t next_prescaler_ = 0;
        std::uint32_t next_reload_ = 4095;
        bool runs_ = false;
        bool open_ = false;
    };
    class Window : public Peripheral {
    public:
        explicit Window(WatchdogPair& pair) : pair_(pair) {}
        [[nodiscard]] std::uint32_t read(std::uint32_t offset) override;
        void write(std::uint32_t offset, std::uint32_t value, unsigned bytes) override;
        [[nodiscard]] std::int64_t next_ns() const override { return std::min(warns_at_, bites_at_); }
        void act(std::int64_t now_ns) override;
        void silence() { warns_at_ = bites_at_ = kNever; }

    private:
        void write_control(std::uint32_t value);
        [[nodiscard]] double count_ns() const;
        [[nodiscard]] std::uint32_t counter() const;
        WatchdogPair& pair_;
        std::int64_t loaded_at_ = 0;
        std::int64_t warns_at_ = kNever;
        std::int64_t bites_at_ = kNever;
        std::uint32_t loaded_ = 127;
        std::uint32_t configuration_ = 127;
        bool active_ = false;
        bool flag_ = false;
    };

    void reset(const std::string& why, std::int64_t ns, const Field& cause);
    void say(const std::string& what) { machine_.violation("watchdog: " + what); }

    Machine& machine_;
    ClockTree& tree_;
    double lsi_hz_;
    Independent independent_;
    Window window_;
    std::vector<WatchdogReset> resets_;
    bool lsi_runs_ = true;
};

}  // namespace sc::model
