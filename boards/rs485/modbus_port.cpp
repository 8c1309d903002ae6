// SPDX-License-Identifier: Apache-2.0
#include "boards/rs485/modbus_port.hpp"

#include <algorithm>
#include <cerrno>
#include <system_error>

#include <modbus/modbus.h>

#include "firmware/sensors/bus_master.hpp"
#include "firmware/sensors/modbus_rtu.hpp"

namespace sc::rs485 {
namespace {

/// Of libmodbus; the master's own patience decides what still counts.
constexpr std::uint32_t kAnswerTimeoutUs = 1'500'000;
constexpr std::uint32_t kByteTimeoutUs = 50'000;
constexpr std::size_t kSumSize = 2;

}  // namespace

ModbusPort::ModbusPort(const std::string& device, const SensorBusConfig& bus)
    : context_(::modbus_new_rtu(device.c_str(), static_cast<int>(bus.baud),
                                bus.parity == SensorParity::even ? 'E' : 'N', 8, 1)),
      character_ns_(sensors::bus_timing(bus).character),
      gap_ns_(sensors::bus_timing(bus).gap) {
    if (context_ == nullptr || ::modbus_connect(context_) != 0) {
        const int error = errno;
        ::modbus_free(context_);
        throw std::system_error(error, std::generic_category(), "open the sensor bus " + device);
    }
    ::modbus_set_response_timeout(context_, kAnswerTimeoutUs / 1'000'000, kAnswerTimeoutUs % 1'000'000);
    ::modbus_set_byte_timeout(context_, 0, kByteTimeoutUs);
    thread_ = std::thread([this] { serve(); });
}

ModbusPort::~ModbusPort() {
    // An exchange under way ends by its own timeout.
    Slot seen = slot_.load();
    while (seen == Slot::asked || !slot_.compare_exchange_strong(seen, Slot::end)) {
        slot_.wait(Slot::asked);
        seen = slot_.load();
    }
    slot_.notify_all();
    thread_.join();
    ::modbus_close(context_);
    ::modbus_free(context_);
}

void ModbusPort::give(std::int64_t tick_ns, std::int64_t period_ns, const SensorTransmission& sent) {
    if (sent.size == 0) {
        return;
    }
    if (slot_.load(std::memory_order_acquire) == Slot::asked) {
        ++lost_;
        return;
    }
    request_ = sent;
    answer_size_ = 0;
    ready_ns_ = tick_ns + period_ns + sent.delay_ns + sent.size * character_ns_ + gap_ns_;
    slot_.store(Slot::asked, std::memory_order_release);
    slot_.notify_one();
}

std::span<const SensorByte> ModbusPort::take(std::int64_t tick_ns) {
    if (slot_.load(std::memory_order_acquire) != Slot::answered) {
        return {};
    }
    const auto count = static_cast<std::int64_t>(answer_size_);
    if (count > 0 && tick_ns < ready_ns_ + count * character_ns_) {
        return {};
    }
    for (std::size_t i = 0; i < answer_size_; ++i) {
        const std::int64_t age = (count - 1 - static_cast<std::int64_t>(i)) * character_ns_ / 1000;
        heard_.at(i) = {answer_.at(i), 0, static_cast<std::uint16_t>(age)};
    }
    slot_.store(Slot::empty, std::memory_order_release);
    return std::span(heard_).first(answer_size_);
}

void ModbusPort::serve() {
    while (true) {
        const Slot seen = slot_.load(std::memory_order_acquire);
        if (seen == Slot::end) {
            return;
        }
        if (seen != Slot::asked) {
            slot_.wait(seen);
            continue;
        }
        exchange();
        slot_.store(Slot::answered, std::memory_order_release);
        slot_.notify_all();
    }
}

/// libmodbus drops what it does not like (a wrong checksum, another slave); the master is to say what was wrong, so
/// the bytes go to it all the same.
void ModbusPort::exchange() {
    std::array<std::uint8_t, MODBUS_RTU_MAX_ADU_LENGTH> bytes{};
    const std::uint8_t slave = request_.bytes[0];
    ::modbus_set_slave(context_, slave);
    ::modbus_flush(context_);
    const int length = static_cast<int>(request_.size - kSumSize);
    if (::modbus_send_raw_request(context_, request_.bytes.data(), length) < 0 || slave == MODBUS_BROADCAST_ADDRESS) {
        return;
    }
    const int got = ::modbus_receive_confirmation(context_, bytes.data());
    std::size_t size = got > 0 ? static_cast<std::size_t>(got) : 0;
    if (got == 0 || (got < 0 && errno == EMBBADCRC)) {
        size = sensors::modbus::reply_size(std::span(bytes).first(3));
    }
    answer_size_ = std::min(size, answer_.size());
    std::copy_n(bytes.begin(), answer_size_, answer_.begin());
}

}  // namespace sc::rs485
