// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/io/control_clock.hpp"

#include "boards/stm32h743/registers/counter.hpp"

namespace sc::stm32h743 {
namespace {

constexpr std::int64_t kNsPerMs = 1'000'000;
constexpr std::uint32_t kReads = 100;

}  // namespace

bool ControlClock::start(std::int64_t origin_ns) noexcept {
    set_bits(tim5::kApb1lenr, tim5::kClock);
    (void)read32(tim5::kApb1lenr);  // a clock is there two cycles behind its bit
    origin_ms_ = origin_ns / kNsPerMs;
    write32(tim5::kCr1, 0);
    write32(tim5::kPsc, 0);
    write32(tim5::kArr, 0xFFFFFFFFU);
    write32(tim5::kEgr, tim5::kGenerateUpdate);  // zero
    write32(tim5::kCr1, tim5::kCounterEnable);
    const std::uint32_t first = read32(tim5::kCnt);
    for (std::uint32_t i = 0; i < kReads; ++i) {
        if (read32(tim5::kCnt) != first) {
            return true;
        }
    }
    return false;
}

std::int64_t ControlClock::now_ns(std::int64_t tick) const noexcept {
    const auto begin = static_cast<std::uint32_t>((tick - origin_ms_) * kCountsPerMs);
    const auto since = static_cast<std::int32_t>(read32(tim5::kCnt) - begin);
    return tick * kNsPerMs + std::int64_t{since} * 25 / 6;
}

std::uint32_t ControlClock::count_at(std::int64_t ns) const noexcept {
    const std::int64_t ms = ns / kNsPerMs;
    return static_cast<std::uint32_t>((ms - origin_ms_) * kCountsPerMs + (ns - ms * kNsPerMs) * 6 / 25);
}

std::int64_t ControlClock::since_ns(std::int64_t ns) const noexcept {
    return std::int64_t{static_cast<std::int32_t>(read32(tim5::kCnt) - count_at(ns))} * 25 / 6;
}

}  // namespace sc::stm32h743
