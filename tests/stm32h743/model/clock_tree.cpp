// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/clock_tree.hpp"

#include <algorithm>
#include <cmath>

namespace sc::model {

using namespace clock_fields;

namespace {

constexpr double kMega = 1e6;
constexpr std::int64_t kHseNs = 2'000;
constexpr std::int64_t kVosNs = 60'000;
constexpr std::int64_t kLockNs = 90'000;
constexpr std::int64_t kStopNs = 2'000;
constexpr std::int64_t kSwitchNs = 500;
constexpr std::uint32_t kSwHsi = 0;
constexpr std::uint32_t kSwPll1 = 3;

struct Limits {
    double core, hclk, apb;
};
/// MHz at VOS0 to VOS3: data sheet, General operating conditions.
constexpr std::array<Limits, 4> kLimits{{{480, 240, 120}, {400, 200, 100}, {300, 150, 75}, {200, 100, 50}}};
/// MHz with 0 to 4 wait states at VOS0 to VOS3: reference manual, Read access latency.
constexpr std::array<std::array<double, 5>, 4> kWaits{
    {{70, 140, 210, 225, 240}, {70, 140, 210, 225, 225}, {55, 110, 165, 225, 225}, {45, 90, 135, 180, 225}}};

/// What may be written and read back; the rest is reserved or not modelled.
std::uint32_t known(std::uint32_t at) {
    std::uint32_t mask = 0;
    for (const Field& one : kAll) {
        mask |= one.address == at ? one.mask() : 0U;
    }
    return mask;
}

}  // namespace

const std::array<ClockTree::PllFields, 2> ClockTree::kPlls{
    {{kPll1On, kPll1Ready, kDivm1, kFraction1, kMedium1, kRange1, kDivp1en, kDivq1en, kDivr1en, kDivn1, kDivp1, kDivq1,
      kDivr1},
     {kPll2On, kPll2Ready, kDivm2, kFraction2, kMedium2, kRange2, kDivp2en, kDivq2en, kDivr2en, kDivn2, kDivp2, kDivq2,
      kDivr2}}};

ClockTree::ClockTree(Machine& machine, Faults faults)
    : machine_(machine),
      faults_(faults),
      rcc_(*this, kRcc),
      pwr_(*this, kPwr),
      flash_(*this, kFlash),
      syscfg_(*this, kSyscfg),
      debug_(*this, kDebug) {
    machine.attach(kRcc, 0x400, rcc_);
    machine.attach(kPwr, 0x400, pwr_);
    machine.attach(kFlash, 0x200, flash_);
    machine.attach(kSyscfg, 0x400, syscfg_);
    machine.attach(kDebug, 4, debug_);
    words_[kCr] = 0x0000'C025;
    words_[kPllckselr] = 0x0202'0200;
    words_[kPllcfgr] = 0x01FF'0000;
    words_[kPll1divr] = words_[kPll2divr] = 0x0101'0280;
    words_[kCr3] = 0x0000'0006;
    words_[kD3cr] = 0x0000'6000;
    words_[kCsr1] = faults.no_supply ? 0x0000'4000U : 0x0000'6000U;
    words_[kFlash] = 0x0000'0037;
    words_[kDebug] = faults.revision << 16U | 0x450U;
}

void ClockTree::preset_running() {
    words_[kCr] |= 0x0F07'0000;  // HSE by its bypass, both PLLs, all ready
    words_[kPllckselr] = 0x0000'2022;
    words_[kPllcfgr] = 0x01FF'0088;
    put(kDivn1, 199);
    put(kDivp1, 1);
    put(kDivn2, 99);
    put(kHpre, 8);
    put(kD1ppre, 4);
    put(kD2ppre1, 4);
    put(kD2ppre2, 4);
    put(kD3ppre, 4);
    put(kSw, kSwPll1);
    put(kSws, kSwPll1);
    put(kScuEn, 0);
    put(kVos, 3);
    scale_ = next_scale_ = 1;
    words_[kFlash] = 0x0000'0022;
}

void ClockTree::preset_overdrive() {
    preset_running();
    put(kSyscfgEn, 1);
    put(kOden, 1);
    scale_ = next_scale_ = 0;
}

std::uint32_t ClockTree::word(std::uint32_t at) const {
    const auto found = words_.find(at);
    return found == words_.end() ? 0 : found->second;
}

void ClockTree::put(const Field& one, std::uint32_t value) {
    std::uint32_t& held = words_[one.address];
    held = (held & ~one.mask()) | ((value << one.first) & one.mask());
}

double ClockTree::divider(std::uint32_t prescaler) {
    constexpr std::array<double, 8> kBy{2, 4, 8, 16, 64, 128, 256, 512};
    return prescaler < 8 ? 1 : kBy[prescaler - 8];
}
double ClockTree::apb_divider(std::uint32_t prescaler) {
    return prescaler < 4 ? 1 : std::exp2(static_cast<double>(prescaler) - 3);
}

double ClockTree::source_hz() const {
    switch (field(kPllSource)) {
        case 0: return on(kHsiReady) ? 64 * kMega / std::exp2(field(kHsiDiv)) : 0;
        case 2: return on(kHseReady) ? 8 * kMega : 0;
        default: return 0;
    }
}
double ClockTree::vco_hz(unsigned number) const {
    const double m = field(kPlls.at(number).m);
    return m == 0 ? 0 : source_hz() / m * (field(kPlls.at(number).n) + 1.0);
}
double ClockTree::system_hz() const {
    return field(kSws) == kSwPll1 ? vco_hz(0) / (field(kDivp1) + 1.0) : 64 * kMega / std::exp2(field(kHsiDiv));
}
double ClockTree::apb_hz(unsigned number) const {
    const std::array<Field, 4> by{kD2ppre1, kD2ppre2, kD1ppre, kD3ppre};
    return hclk_hz() / apb_divider(field(by.at(number - 1)));
}
double ClockTree::timer_hz(unsigned number) const {
    const double by = hclk_hz() / apb_hz(number);
    const double free = on(kTimpre) ? 4 : 2;
    return by <= free ? hclk_hz() : apb_hz(number) * free;
}
double ClockTree::fdcan_hz() const {
    switch (field(kFdcanSel)) {
        case 0: return on(kHseReady) ? 8 * kMega : 0;
        case 1: return on(kPll1Ready) && on(kDivq1en) ? vco_hz(0) / (field(kDivq1) + 1.0) : 0;
        case 2: return on(kPll2Ready) && on(kDivq2en) ? vco_hz(1) / (field(kDivq2) + 1.0) : 0;
        default: return 0;
    }
}
double ClockTree::usart_hz(bool usart16) const {
    return field(usart16 ? kUsart16Sel : kUsart28Sel) == 0 ? apb_hz(usart16 ? 2 : 1) : 0;
}
int ClockTree::scale() const { return machine_.now_ns() >= vos_at_ ? next_scale_ : scale_; }

bool ClockTree::may_set_pll(unsigned number) const { return !on(kPlls.at(number).on) && !on(kPlls.at(number).ready); }

/// What time has brought.
void ClockTree::settle() {
    const std::int64_t now = machine_.now_ns();
    const auto due = [&](std::int64_t& when) {
        const bool is = now >= when;
        when = is ? Peripheral::kNever : when;
        return is;
    };
    if (due(hse_at_)) {
        put(kHseReady, 1);
    }
    for (unsigned i = 0; i < 2; ++i) {
        if (due(lock_at_.at(i))) {
            put(kPlls.at(i).ready, 1);
        }
        if (due(stop_at_.at(i))) {
            put(kPlls.at(i).ready, 0);
        }
    }
    if (due(vos_at_)) {
        scale_ = next_scale_;
        put(kVosReady, 1);
    }
    if (due(switch_at_)) {
        put(kSws, field(kSw));
        check_limits("the switch");
    }
}

std::uint32_t ClockTree::read(std::uint32_t at) {
    settle();
    if (at == kApb2enr || at == kApb3enr || at == kApb4enr || at == kAhb2enr || at == kAhb4enr) {
        settled_[at] = word(at);
    }
    if (at >= kSyscfg && at < kSyscfg + 0x400 && !(on(kSyscfgEn) && settled(kSyscfgEn))) {
        say("SYSCFG is read without its clock");
        return 0;
    }
    return word(at);
}

void ClockTree::write(std::uint32_t at, std::uint32_t value, unsigned bytes) {
    settle();
    if (bytes != 4) {
        say("written by parts");
        return;
    }
    if (((value ^ word(at)) & ~known(at)) != 0) {
        say("a bit that is reserved or not modelled changes");
    }
    switch (at) {
        case kCr: return write_cr(value);
        case kCfgr: return write_cfgr(value);
        case kD3cr: return write_scale(value);
        case kCr3: return write_supply(value);
        case kPwrcr: return write_syscfg(value);
        case kPllckselr:
        case kPllcfgr:
        case kPll1divr:
        case kPll2divr: return write_pll(at, value);
        case kD2ccip1r: return write_fdcan(value);
        case kPwrCr1: words_[at] = value; return;
        case kApb2enr:
        case kApb4enr:
        case kAhb2enr:
        case kAhb4enr:
            settled_[at] &= value;
            words_[at] = value;
            return;
        case kApb3enr:
            if (on(kWwdgEn) && (value & kWwdgEn.mask()) == 0) {
                say("the clock of WWDG cannot be taken back");
            }
            settled_[at] &= value;
            words_[at] = value;
            return;
        case kRsr: words_[at] = (value & kForgetResets.mask()) != 0 ? 0 : word(at); return;
        case kGcr: words_[at] |= value; return;
        case kCsr1:
        case kCifr:
        case kDebug:
        case kFlashSr1:
        case kFlashSr2: return say("a register that is read alone is written");
        case kFlash:
            if (faults_.deaf_flash) {
                return;
            }
            break;
        default: break;
    }
    words_[at] = value;
    check_limits("a divider or the wait states changed");
}

void ClockTree::write_cr(std::uint32_t value) {
    const auto wants = [&](const Field& one) { return (value & one.mask()) != 0; };
    if (wants(kHseBypass) != on(kHseBypass)) {
        if (on(kHseOn) || on(kHseReady)) {
            say("the bypass changes while HSE is on");
        } else {
            put(kHseBypass, wants(kHseBypass) ? 1 : 0);
        }
    }
    if (wants(kHseOn) && !on(kHseOn)) {
        if (!on(kHseBypass)) {
            say("HSE looks for a crystal, and there is none");
        }
        put(kHseOn, 1);
        hse_at_ = faults_.no_hse || !on(kHseBypass) ? Peripheral::kNever : machine_.now_ns() + kHseNs;
    } else if (!wants(kHseOn) && on(kHseOn)) {
        if (field(kPllSource) == 2 && (!may_set_pll(0) || !may_set_pll(1))) {
            say("HSE goes while a PLL needs it");
        }
        put(kHseOn, 0);
        put(kHseReady, 0);
        hse_at_ = Peripheral::kNever;
    }
    if (wants(kHseGuard) != on(kHseGuard)) {
        if (wants(kHseGuard) && !on(kHseReady)) {
            say("HSE is guarded before it is ready");
        }
        put(kHseGuard, wants(kHseGuard) || on(kHseGuard) ? 1 : 0);
    }
    if (!wants(kHsiOn) && field(kSws) == kSwHsi) {
        say("HSI goes while the core needs it");
    } else {
        put(kHsiOn, wants(kHsiOn) ? 1 : 0);
        put(kHsiReady, wants(kHsiOn) ? 1 : 0);
    }
    if (((value & kHsiDiv.mask()) >> kHsiDiv.first) != field(kHsiDiv)) {
        if (field(kPllSource) == 0 && (!may_set_pll(0) || !may_set_pll(1))) {
            say("HSI is divided otherwise while a PLL needs it");
        }
        put(kHsiDiv, (value & kHsiDiv.mask()) >> kHsiDiv.first);
        check_limits("HSI is divided otherwise");
    }
    for (unsigned i = 0; i < 2; ++i) {
        const PllFields& pll = kPlls.at(i);
        if (wants(pll.on) && !on(pll.on)) {
            start_pll(i);
        } else if (!wants(pll.on) && on(pll.on)) {
            if (i == 0 && (field(kSws) == kSwPll1 || field(kSw) == kSwPll1)) {
                say("PLL1 goes while the core needs it");
                continue;
            }
            put(pll.on, 0);
            lock_at_.at(i) = Peripheral::kNever;
            stop_at_.at(i) = machine_.now_ns() + kStopNs;
        }
    }
}

void ClockTree::start_pll(unsigned number) {
    const PllFields& pll = kPlls.at(number);
    const std::string name = "PLL" + std::to_string(number + 1) + ' ';
    const double source = source_hz();
    if (source == 0) {
        say(name + "starts without a source");
    }
    const double m = field(pll.m);
    const double reference = m == 0 ? 0 : source / m;
    const double low = kMega * std::exp2(field(pll.range));
    if (reference < low || reference > 2 * low) {
        say(name + "has a reference out of the range that was set");
    }
    const double vco = vco_hz(number);
    const double most = scale() == 0 ? 960 * kMega : 836 * kMega;
    if (on(pll.medium) ? vco < 150 * kMega || vco > 420 * kMega : vco < 192 * kMega || vco > most) {
        say(name + "has a VCO out of its range");
    }
    if (on(pll.fraction)) {
        say(name + "has a fraction that is not modelled");
    }
    if (number == 0 && field(pll.p) % 2 == 0) {
        say(name + "divides by an odd number");
    }
    const std::array<std::pair<Field, Field>, 3> outputs{{{pll.p_on, pll.p}, {pll.q_on, pll.q}, {pll.r_on, pll.r}}};
    for (const auto& [enabled, factor] : outputs) {
        if (on(enabled) && vco / (field(factor) + 1.0) > kLimits.at(static_cast<unsigned>(scale())).core * kMega) {
            say(name + "lets out more than the voltage allows");
        }
    }
    put(pll.on, 1);
    stop_at_.at(number) = Peripheral::kNever;
    const bool dead = source == 0 || (number == 0 ? faults_.no_pll1 : faults_.no_pll2);
    lock_at_.at(number) = dead ? Peripheral::kNever : machine_.now_ns() + kLockNs;
}

void ClockTree::write_cfgr(std::uint32_t value) {
    words_[kCfgr] = (value & ~kSws.mask()) | (word(kCfgr) & kSws.mask());
    const std::uint32_t to = field(kSw);
    if (to == field(kSws)) {
        switch_at_ = Peripheral::kNever;
        return;
    }
    const bool there = to == kSwPll1 ? on(kPll1Ready) && on(kDivp1en) : to == kSwHsi && on(kHsiReady);
    if (!there) {
        return say("the core is sent to a clock that is not there");
    }
    if (!faults_.no_switch) {
        switch_at_ = machine_.now_ns() + kSwitchNs;
    }
}

void ClockTree::write_supply(std::uint32_t value) {
    constexpr std::uint32_t kAllBits = 7;
    if (((value ^ word(kCr3)) & kAllBits & ~kScuEn.mask()) != 0 && !on(kScuEn)) {
        say("the supply is set a second time");
        return;
    }
    words_[kCr3] = value;
    if (on(kBypass) == on(kLdoEn)) {
        say("the supply is neither LDO nor bypass, or both");
    }
    put(kScuEn, 0);
}

void ClockTree::write_scale(std::uint32_t value) {
    if (on(kScuEn)) {
        say("the voltage is scaled before the supply is set");
    }
    if (!on(kActualReady)) {
        say("the voltage is scaled before the supply is there");
    }
    const std::uint32_t vos = (value & kVos.mask()) >> kVos.first;
    if (vos == 0) {
        return say("a voltage scale that is reserved");
    }
    if (vos == field(kVos)) {
        return;
    }
    if (on(kOden)) {
        say("the voltage is scaled under overdrive");
    }
    put(kVos, vos);
    put(kVosReady, 0);
    next_scale_ = 4 - static_cast<int>(vos);
    scale_ = std::max(scale(), next_scale_);
    vos_at_ = faults_.no_scale1 ? Peripheral::kNever : machine_.now_ns() + kVosNs;
    check_limits("the voltage changed");
}

void ClockTree::write_syscfg(std::uint32_t value) {
    if (!on(kSyscfgEn) || !settled(kSyscfgEn)) {
        return say("SYSCFG is written without its clock, or before it has settled");
    }
    const bool overdrive = (value & kOden.mask()) != 0;
    if (overdrive == on(kOden)) {
        return;
    }
    if (overdrive && (field(kVos) != 3 || !on(kVosReady))) {
        return say("overdrive before scale 1 is ready");
    }
    put(kOden, overdrive ? 1 : 0);
    put(kVosReady, 0);
    next_scale_ = overdrive ? 0 : 1;
    scale_ = 1;
    vos_at_ = faults_.no_scale0 ? Peripheral::kNever : machine_.now_ns() + kVosNs;
    check_limits("overdrive changed");
}

void ClockTree::write_pll(std::uint32_t at, std::uint32_t value) {
    const std::uint32_t changed = value ^ word(at);
    for (unsigned i = 0; i < 2; ++i) {
        const PllFields& pll = kPlls.at(i);
        std::uint32_t of_pll = at == kPllckselr ? kPllSource.mask() : 0;
        for (const Field& one :
             {pll.m, pll.fraction, pll.medium, pll.range, pll.p_on, pll.q_on, pll.r_on, pll.n, pll.p, pll.q, pll.r}) {
            of_pll |= one.address == at ? one.mask() : 0U;
        }
        if ((changed & of_pll) != 0 && !may_set_pll(i)) {
            say("PLL" + std::to_string(i + 1) + " is set while it runs");
        }
    }
    words_[at] = value;
}

void ClockTree::write_fdcan(std::uint32_t value) {
    words_[kD2ccip1r] = value;
    if (fdcan_hz() == 0) {
        say("FDCAN gets a clock that is not there");
    }
    if (fdcan_hz() > apb_hz(1)) {
        say("FDCAN is faster than its bus");
    }
}

void ClockTree::check_limits(const std::string& after) {
    const Limits& most = kLimits.at(static_cast<unsigned>(scale()));
    const auto check = [&](double hz, double mhz, const std::string& what) {
        if (hz > mhz * kMega * (1 + 1e-12)) {
            say(what + " is too fast for the voltage after " + after);
        }
    };
    check(core_hz(), most.core, "the core");
    check(hclk_hz(), most.hclk, "HCLK");
    for (unsigned i = 1; i <= 4; ++i) {
        check(apb_hz(i), most.apb, "APB" + std::to_string(i));
    }
    const std::uint32_t waits = std::min(field(kLatency), 4U);
    if (hclk_hz() > kWaits.at(static_cast<unsigned>(scale())).at(waits) * kMega) {
        say("too few wait states after " + after);
    }
    const double hclk = hclk_hz() / kMega;
    const std::uint32_t delay = hclk <= 70 ? 0 : hclk <= 185 ? 1 : 2;
    if (field(kWriteDelay) < delay) {
        say("the flash's write delay is too short after " + after);
    }
}

}  // namespace sc::model
