// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/source_pins.hpp"

namespace sc::sim {
namespace {

constexpr std::uint8_t kPin11 = 1;
constexpr std::uint8_t kPin12 = 2;
constexpr std::uint8_t kPin16 = 4;
constexpr std::uint8_t kPin21 = 8;

/// Which of pins 11 and 12 a maker raises beside the four codes of pins 16 and 21.
struct Dialect {
    std::uint8_t warning;
    std::uint8_t starting;
    std::uint8_t housekeeping;
    std::uint8_t system;
    std::uint8_t strange;
};
constexpr Dialect kIpg{kPin16 | kPin12, kPin16 | kPin11, kPin21 | kPin11, kPin11 | kPin12, kPin21 | kPin12};
constexpr Dialect kRaycus{kPin16 | kPin11, kPin16 | kPin12, kPin21 | kPin12, kPin11 | kPin12, kPin21 | kPin11};
constexpr Dialect kJpt{kPin16 | kPin11 | kPin12, kPin16 | kPin12, kPin21 | kPin12, kPin11, kPin21 | kPin11};

}  // namespace

std::uint8_t source_pins(LaserSource source, SourceTrouble trouble) noexcept {
    const Dialect& dialect = source == LaserSource::ipg ? kIpg : (source == LaserSource::raycus ? kRaycus : kJpt);
    switch (trouble) {
        case SourceTrouble::none: return kPin16;
        case SourceTrouble::warning: return dialect.warning;
        case SourceTrouble::starting: return dialect.starting;
        case SourceTrouble::back_reflection: return kPin16 | kPin21;
        case SourceTrouble::temperature: return 0;
        case SourceTrouble::main_supply: return kPin21;
        case SourceTrouble::housekeeping: return dialect.housekeeping;
        case SourceTrouble::system: return dialect.system;
        case SourceTrouble::strange: return dialect.strange;
    }
    return 0;
}

}  // namespace sc::sim
