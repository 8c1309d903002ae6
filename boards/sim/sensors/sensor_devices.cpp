// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/sensors/sensor_devices.hpp"

#include <cmath>
#include <cstdio>

namespace sc::sim {
namespace {

constexpr std::uint8_t kReadHolding = 0x03;
constexpr std::uint8_t kReadInput = 0x04;
constexpr std::uint8_t kWriteOne = 0x06;
constexpr std::uint8_t kWriteMany = 0x10;
constexpr std::uint8_t kIllegalFunction = 1;
constexpr std::uint8_t kIllegalAddress = 2;
constexpr std::uint8_t kDeviceFailure = 4;

constexpr std::int64_t kTriangulationTurnRoundNs = 200'000;
constexpr std::int64_t kPhaseTurnRoundNs = 400'000;
constexpr std::int64_t kSingleNs = 120'000'000;

std::int64_t nanoseconds(double seconds) { return std::llround(seconds * 1e9); }

/// Bit by bit, as the standard's appendix draws it.
unsigned modbus_checksum(const std::vector<std::uint8_t>& bytes, std::size_t count) {
    unsigned sum = 0xFFFF;
    for (std::size_t i = 0; i < count; ++i) {
        sum ^= bytes[i];
        for (int bit = 0; bit < 8; ++bit) {
            const bool one = (sum & 1U) != 0;
            sum >>= 1U;
            sum ^= one ? 0xA001U : 0U;
        }
    }
    return sum;
}

unsigned word(const std::vector<std::uint8_t>& bytes, std::size_t at) { return bytes[at] * 256U + bytes[at + 1]; }

void push(std::vector<std::uint8_t>& bytes, unsigned value) {
    bytes.push_back(static_cast<std::uint8_t>(value % 256U));
}
void push_word(std::vector<std::uint8_t>& bytes, unsigned value) {
    push(bytes, value / 256U);
    push(bytes, value);
}

}  // namespace

SensorDevice::SensorDevice(double update_s) : update_ns_(nanoseconds(update_s)) {}

// --- Modbus

ModbusDevice::ModbusDevice(const SensorBusConfig& bus, std::uint8_t address, double update_s,
                           std::int64_t turn_round_ns)
    : SensorDevice(update_s),
      address_(address),
      character_ns_((bus.parity == SensorParity::none ? 10 : 11) * 1'000'000'000LL / bus.baud),
      inner_ns_(bus.baud > 19'200 && bus.short_gaps == 0 ? 750'000 : character_ns_ * 3 / 2),
      gap_ns_(bus.baud > 19'200 && bus.short_gaps == 0 ? 1'750'000 : character_ns_ * 7 / 2),
      turn_round_ns_(turn_round_ns) {}

void ModbusDevice::hear(std::uint8_t byte, bool garbled, std::int64_t end_ns) {
    const std::int64_t silence = end_ns - character_ns_ - last_ns_;
    if (frame_.empty()) {
        broken_ = false;
    } else if (silence > inner_ns_) {
        broken_ = true;
    }
    broken_ = broken_ || garbled;
    frame_.push_back(byte);
    last_ns_ = end_ns;
}

std::optional<std::int64_t> ModbusDevice::due_ns() const {
    if (!frame_.empty()) {
        return last_ns_ + gap_ns_;
    }
    if (!slow_request_.empty()) {
        return slow_at_ns_;
    }
    return std::nullopt;
}

std::optional<SlaveAnswer> ModbusDevice::act(std::int64_t now_ns) {
    std::vector<std::uint8_t> request;
    if (!frame_.empty()) {
        request.swap(frame_);
        if (broken_) {
            return std::nullopt;
        }
        const bool own = request.size() >= 8 && request[0] == address_;
        const std::int64_t wait = own ? takes_ns(static_cast<std::uint16_t>(word(request, 2))) : 0;
        if (wait > 0) {
            slow_request_ = request;
            slow_at_ns_ = now_ns + wait;
            return std::nullopt;
        }
    } else {
        request.swap(slow_request_);
    }
    SlaveAnswer answer;
    answer.bytes = serve(request, now_ns);
    if (answer.bytes.empty()) {
        return std::nullopt;
    }
    answer.begin_ns = now_ns + turn_round_ns_;
    if (trouble_ == SensorTrouble::chopped) {
        answer.pause_before = answer.bytes.size() / 2;
        answer.pause_ns = inner_ns_ + 3 * character_ns_;
    }
    return answer;
}

std::vector<std::uint8_t> ModbusDevice::serve(const std::vector<std::uint8_t>& request, std::int64_t now_ns) {
    if (request.size() < 8 || trouble_ == SensorTrouble::silent) {
        return {};
    }
    const std::size_t body = request.size() - 2;
    const bool sound = request[body] + request[body + 1] * 256U == modbus_checksum(request, body);
    const bool broadcast = request[0] == 0;
    if (!sound || (request[0] != address_ && !broadcast)) {
        return {};
    }
    const std::uint8_t function = request[1];
    const unsigned first = word(request, 2);
    const unsigned value = word(request, 4);
    std::uint8_t refusal = 0;
    std::vector<std::uint8_t> answer{request[0], function};
    if (trouble_ == SensorTrouble::exception) {
        refusal = kDeviceFailure;
    } else if ((function == kReadHolding || function == kReadInput) && request.size() == 8 && value >= 1 &&
               value <= 125) {
        push(answer, 2 * value);
        for (unsigned i = 0; i < value && refusal == 0; ++i) {
            const auto one = read(function, static_cast<std::uint16_t>(first), i, now_ns);
            refusal = one ? refusal : kIllegalAddress;
            push_word(answer, one.value_or(0));
        }
    } else if (function == kWriteOne && request.size() == 8) {
        push_word(answer, first);
        push_word(answer, value);
        refusal = write(static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(value), now_ns) ? refusal
                                                                                                      : kIllegalAddress;
    } else if (function == kWriteMany && request.size() == 9 + 2 * value && request[6] == 2 * value) {
        push_word(answer, first);
        push_word(answer, value);
        for (unsigned i = 0; i < value && refusal == 0; ++i) {
            const auto one = static_cast<std::uint16_t>(word(request, 7 + 2 * i));
            refusal = write(static_cast<std::uint16_t>(first + i), one, now_ns) ? refusal : kIllegalAddress;
        }
    } else {
        refusal = kIllegalFunction;
    }
    if (broadcast) {
        return {};
    }
    if (refusal != 0) {
        answer = {request[0], static_cast<std::uint8_t>(function | 0x80U), refusal};
    }
    if (trouble_ == SensorTrouble::wrong_slave) {
        answer[0] = static_cast<std::uint8_t>(answer[0] + 1);
    }
    const unsigned sum = modbus_checksum(answer, answer.size()) ^ (trouble_ == SensorTrouble::crc ? 0x0100U : 0U);
    push(answer, sum);
    push(answer, sum / 256U);
    return answer;
}

// --- triangulation

TriangulationDevice::TriangulationDevice(const SensorBusConfig& bus, const SensorConfig& config,
                                         const YSensorTruth& truth, std::uint64_t seed, std::uint64_t stream)
    : ModbusDevice(bus, config.address, truth.update, kTriangulationTurnRoundNs),
      truth_(truth),
      model_(truth, seed, stream),
      delay_ns_(nanoseconds(truth.delay)) {}

void TriangulationDevice::measure(std::int64_t t_ns, const std::optional<Target>& target) {
    const bool blind = trouble_ == SensorTrouble::blind || !laser_;
    const auto value = model_.measure(blind ? std::nullopt : target);
    if (value && trouble_ != SensorTrouble::stale) {
        coming_.push_back({t_ns + delay_ns_, *value});
    }
    measured(t_ns);
}

std::uint16_t TriangulationDevice::value_at(std::int64_t now_ns) {
    while (!coming_.empty() && coming_.front().from_ns <= now_ns) {
        value_ = coming_.front().value;
        coming_.pop_front();
    }
    return latched_.value_or(value_);
}

std::int64_t TriangulationDevice::takes_ns(std::uint16_t first) const {
    static_cast<void>(first);
    return 0;
}

std::optional<std::uint16_t> TriangulationDevice::read(std::uint8_t function, std::uint16_t first, unsigned i,
                                                       std::int64_t now_ns) {
    const unsigned reg = first + i;
    if (function == kReadHolding) {
        if (reg == 10) {
            return laser_ ? 1 : 0;
        }
        return reg == 39 ? std::optional<std::uint16_t>(2) : std::nullopt;
    }
    switch (reg) {
        case 1: return 602;
        case 2: return 17;
        case 3: return static_cast<std::uint16_t>(truth_.serial + (trouble_ == SensorTrouble::foreign ? 1.0 : 0.0));
        case 4: return static_cast<std::uint16_t>(std::lround(truth_.base * 1e3));
        case 5: return static_cast<std::uint16_t>(std::lround(truth_.range * 1e3));
        case 6: return value_at(now_ns);
        default: return std::nullopt;
    }
}

bool TriangulationDevice::write(std::uint16_t reg, std::uint16_t value, std::int64_t now_ns) {
    if (reg == 10) {
        laser_ = value != 0;
        return true;
    }
    if (reg == 41) {
        latched_.reset();
        latched_ = value_at(now_ns);
        return true;
    }
    return false;
}

// --- phase shift

PhaseDevice::PhaseDevice(const SensorBusConfig& bus, const SensorConfig& config, const TripleTruth& truth,
                         std::size_t beam, std::uint64_t seed, std::uint64_t stream)
    : ModbusDevice(bus, config.address, truth.update, kPhaseTurnRoundNs),
      truth_(truth),
      beam_(beam),
      own_address_(config.address),
      model_(truth, seed, stream),
      delay_ns_(nanoseconds(truth.delay)) {}

void PhaseDevice::measure(std::int64_t t_ns, const std::optional<Target>& target) {
    const bool blind = trouble_ == SensorTrouble::blind || !laser_;
    const auto value = model_.measure(blind ? std::nullopt : target, truth_.beam.at(beam_),
                                      trouble_ == SensorTrouble::slipped ? 1 : 0);
    if (trouble_ != SensorTrouble::stale) {
        coming_.push_back({t_ns + delay_ns_, value});
    }
    measured(t_ns);
}

std::uint32_t PhaseDevice::value_at(std::int64_t now_ns) {
    while (!coming_.empty() && coming_.front().from_ns <= now_ns) {
        value_ = coming_.front().value;
        coming_.pop_front();
    }
    return value_;
}

std::int64_t PhaseDevice::takes_ns(std::uint16_t first) const { return first == 0x000F ? kSingleNs : 0; }

/// The registers overlap: the value's low word is read at 0x0002 behind 0x0001, and the offset at 0x0002 by itself.
std::optional<std::uint16_t> PhaseDevice::read(std::uint8_t function, std::uint16_t first, unsigned i,
                                               std::int64_t now_ns) {
    const bool value = first == 0x0001 || first == 0x000F;
    if (function != kReadHolding || i > (value ? 1U : 0U)) {
        return std::nullopt;
    }
    if (value) {
        return static_cast<std::uint16_t>(value_at(now_ns) >> (i == 0 ? 16U : 0U) & 0xFFFFU);
    }
    if (first == 0x0002) {
        const double other = trouble_ == SensorTrouble::foreign ? 1.0 : 0.0;
        return static_cast<std::uint16_t>(truth_.beam.at(beam_).stored_offset + other);
    }
    return first == 0x000C ? std::optional<std::uint16_t>(own_address_) : std::nullopt;
}

bool PhaseDevice::write(std::uint16_t reg, std::uint16_t value, std::int64_t now_ns) {
    static_cast<void>(now_ns);
    if (reg != 0x0003) {
        return false;
    }
    laser_ = value != 0;
    return true;
}

// --- lines of text

AsciiDevice::AsciiDevice(const SensorBusConfig& bus, const SensorConfig& config, const YSensorTruth& truth,
                         std::uint64_t seed, std::uint64_t stream)
    : SensorDevice(truth.update),
      truth_(truth),
      address_(config.address),
      gap_ns_(35'000'000'000LL / bus.baud),
      model_(truth, seed, stream) {}

void AsciiDevice::measure(std::int64_t t_ns, const std::optional<Target>& target) {
    const auto value = model_.measure(trouble_ == SensorTrouble::blind ? std::nullopt : target);
    if (value && trouble_ != SensorTrouble::stale) {
        value_ = *value;
    }
    measured(t_ns);
}

void AsciiDevice::hear(std::uint8_t byte, bool garbled, std::int64_t end_ns) {
    if (byte == '%' || garbled || line_.size() > 40) {
        line_.clear();
    }
    line_.push_back(static_cast<char>(byte));
    if (byte == '\r') {
        question_.swap(line_);
        line_.clear();
        answer_at_ = end_ns + gap_ns_;
    }
}

std::string AsciiDevice::value_text() const {
    const double mm = value_ == 0 ? 950.0 : (truth_.base + truth_.range * value_ / 16384.0) * 1e3;
    char text[16] = {};
    (void)std::snprintf(text, sizeof(text), "%+09.4f", mm);
    return text;
}

std::optional<SlaveAnswer> AsciiDevice::act(std::int64_t now_ns) {
    answer_at_.reset();
    const auto with_check = [](const std::string& text) {
        unsigned check = 0;
        for (const char c : text) {
            check ^= static_cast<unsigned char>(c);
        }
        char tail[4] = {};
        (void)std::snprintf(tail, sizeof(tail), "%02X", check & 0xFFU);
        return text + tail + "\r";
    };
    char head[8] = {};
    (void)std::snprintf(head, sizeof(head), "%%%02u", address_ % 100U);
    if (trouble_ == SensorTrouble::silent || question_ != with_check(std::string(head) + "#RMD")) {
        return std::nullopt;
    }
    if (trouble_ == SensorTrouble::wrong_slave) {
        (void)std::snprintf(head, sizeof(head), "%%%02u", (address_ + 1) % 100U);
    }
    std::string text =
        with_check(std::string(head) + (trouble_ == SensorTrouble::exception ? "!04" : "$RMD" + value_text()));
    if (trouble_ == SensorTrouble::crc) {
        text[text.size() - 2] = text[text.size() - 2] == '0' ? '1' : '0';
    }
    return SlaveAnswer{now_ns, {text.begin(), text.end()}, 0, 0};
}

}  // namespace sc::sim
