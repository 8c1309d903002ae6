// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/laser.hpp"

#include <algorithm>
#include <cmath>

namespace sc::sim {
namespace {

/// Trigger of pulse j of a run, in 1/256 ns.
std::int64_t trigger_ns256(const LaserRun& run, std::int64_t j) {
    return run.t0_ns * 256 + j * run.period_ns256 + run.change_ns256 * (j * (j - 1) / 2);
}

std::int64_t period_ns256(const LaserRun& run, std::int64_t j) { return run.period_ns256 + j * run.change_ns256; }

std::int64_t rounded(std::int64_t ns256) { return (ns256 + 128) >> 8; }

}  // namespace

LaserPlant::LaserPlant(const LaserConfig& config, const LaserTruth& truth) : config_(config), truth_(truth) {}

void LaserPlant::set_master_oscillator(bool on, std::int64_t t_ns) noexcept {
    if (!on) {
        oscillator_on_ns_ = kNever;
    } else if (oscillator_on_ns_ == kNever) {
        oscillator_on_ns_ = t_ns;
    }
}

void LaserPlant::queue(const LaserRun& run, bool allowed) {
    if (allowed) {
        runs_.push_back({run});
        if (run.latch_ns > 0) {
            strobe(run.t0_ns - run.latch_ns, run.power);
        }
    } else {
        counters_.not_allowed += run.count;
    }
}

void LaserPlant::cancel(std::int64_t from_ns) {
    for (Queued& queued : runs_) {
        queued.end_ns = std::min(queued.end_ns, from_ns);
    }
    std::erase_if(strobes_, [from_ns](const Strobe& s) { return s.laid_ns >= from_ns; });
}

void LaserPlant::shut_gate(std::int64_t from_ns) noexcept { gate_shut_ns_ = std::min(gate_shut_ns_, from_ns); }

void LaserPlant::cut_light(std::int64_t from_ns) noexcept { light_cut_ns_ = std::min(light_cut_ns_, from_ns); }

void LaserPlant::strobe(std::int64_t rise_ns, std::uint8_t byte) {
    strobes_.push_back({rise_ns - config_.latch_setup_ns, rise_ns, rise_ns + config_.latch_width_ns, byte});
}

void LaserPlant::clear_power(std::int64_t t_ns) {
    const std::uint8_t last = strobes_.empty() ? byte_ : strobes_.back().byte;
    if (last != 0) {
        strobe(t_ns + config_.latch_setup_ns, 0);
    }
    take_strobes(t_ns);
}

void LaserPlant::take_strobes(std::int64_t until_ns) {
    while (!strobes_.empty() && strobes_.front().rise_ns <= until_ns) {
        const Strobe s = strobes_.front();
        strobes_.pop_front();
        const bool good = s.rise_ns - s.laid_ns >= kLatchSetupNs && s.fall_ns - s.rise_ns >= kLatchWidthNs &&
                          s.laid_ns >= last_fall_ns_;
        last_fall_ns_ = s.fall_ns;
        if (!good) {
            ++counters_.bad_strobes;
            continue;
        }
        ++counters_.strobes;
        relax(s.rise_ns);
        byte_ = s.byte;
    }
}

void LaserPlant::relax(std::int64_t t_ns) {
    if (truth_.power_time_constant > 0.0) {
        const double elapsed = static_cast<double>(t_ns - power_ns_) * 1e-9;
        power_ = target() + (power_ - target()) * std::exp(-elapsed / truth_.power_time_constant);
    }
    power_ns_ = t_ns;
}

double LaserPlant::power_at(std::int64_t t_ns) {
    if (truth_.power_time_constant <= 0.0) {
        return target();
    }
    relax(t_ns);
    return power_;
}

double LaserPlant::gain_at(std::int64_t t_ns, double period_ns) {
    // A pause is what lies between two pulses beyond the period; at a steady rate nothing builds up.
    double pause = 1.0;
    if (gain_ns_) {
        pause = std::max(0.0, static_cast<double>(t_ns - *gain_ns_) - period_ns - 1.0) * 1e-9;
    }
    gain_ns_ = t_ns;
    const double full = truth_.first_pulse_excess;
    excess_ = full + (excess_ - full) * std::exp(-pause / truth_.gain_build_up);
    const double gain = 1.0 + excess_;
    excess_ *= 1.0 - 1.0 / truth_.first_pulses;
    return gain;
}

bool LaserPlant::stopped(const Queued& queued, std::int64_t trigger_ns, std::int64_t light_ns) {
    if (trigger_ns >= queued.end_ns || trigger_ns >= gate_shut_ns_) {
        ++counters_.cancelled;
        return true;
    }
    if (triggers_) {
        triggers_(trigger_ns);
    }
    if (light_ns >= light_cut_ns_) {
        ++counters_.cut;
        return true;
    }
    return false;
}

LaserPulse LaserPlant::shoot(const Queued& queued, std::int64_t trigger_ns, std::int64_t light_ns) {
    const double period_ns = static_cast<double>(period_ns256(queued.run, queued.done)) / 256.0 / queued.run.pick;
    const double rate = 1e9 / period_ns;
    if (rate < config_.prr_min.si() * 0.999 || rate > config_.prr_nominal.si() * 1.001) {
        ++counters_.out_of_rate;
    }
    take_strobes(trigger_ns);
    counters_.wrong_power += byte_ != queued.run.power ? 1 : 0;
    LaserPulse pulse{light_ns};
    const double gain = gain_at(trigger_ns, static_cast<double>(period_ns256(queued.run, queued.done)) / 256.0);
    const double energy_nj = power_at(trigger_ns) * gain * period_ns;
    pulse.energy_nj = static_cast<std::uint32_t>(std::clamp(energy_nj + 0.5, 0.0, 4e9));
    pulse.lit = oscillator_on_ns_ != kNever && trigger_ns - oscillator_on_ns_ >= config_.mo_wait_ns;
    if (!pulse.lit) {
        ++counters_.unlit;
    }
    return pulse;
}

std::optional<LaserPulse> LaserPlant::next(std::int64_t limit_ns) {
    while (!runs_.empty()) {
        Queued& first = runs_.front();
        if (first.done >= first.run.count) {
            runs_.pop_front();
            continue;
        }
        const std::int64_t trigger = trigger_ns256(first.run, first.done);
        const std::int64_t light_ns = rounded(trigger + config_.latency_ns * 256);
        if (light_ns >= limit_ns) {
            return std::nullopt;
        }
        if (trigger < last_trigger_ns256_) {
            ++counters_.disordered;
        }
        last_trigger_ns256_ = trigger;
        const bool stop = stopped(first, rounded(trigger), light_ns);
        const LaserPulse pulse = stop ? LaserPulse{} : shoot(first, rounded(trigger), light_ns);
        ++first.done;
        if (!stop) {
            return pulse;
        }
    }
    return std::nullopt;
}

}  // namespace sc::sim
