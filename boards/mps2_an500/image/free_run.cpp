// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an500/image/free_run.hpp"

#include <array>

#include "boards/mps2_an500/image/registers.hpp"
#include "boards/mps2_an500/image/uart.hpp"
#include "firmware/motion/path_motion.hpp"
#include "firmware/recording/io_image.hpp"

namespace sc::mps2_an500 {
namespace {

constexpr std::uint32_t kBaud = 115'200;

std::array<std::uint8_t, kLinkBytesPerTick> received;

/// Bytes for the line that have not gone yet. A controller that speaks faster than the line loses whole ticks' bytes;
/// the frames' checksums tell the other side.
class SendQueue {
public:
    void push(std::span<const std::uint8_t> bytes) noexcept {
        if (bytes.size() > bytes_.size() - (end_ - begin_)) {
            return;
        }
        for (const std::uint8_t byte : bytes) {
            bytes_[end_++ % bytes_.size()] = byte;
        }
    }
    void send_some() noexcept {
        while (begin_ != end_ && uart_try_send(bytes_[begin_ % bytes_.size()])) {
            ++begin_;
        }
    }

private:
    std::array<std::uint8_t, 2 * kLinkBytesPerTick> bytes_{};
    std::size_t begin_ = 0;
    std::size_t end_ = 0;
};
SendQueue queue;

void start_tick_timer(std::int64_t period_ns) noexcept {
    systick_reload() = static_cast<std::uint32_t>(period_ns * (kCoreClockHz / 1'000'000) / 1000) - 1;
    systick_value() = 0;
    systick_control() = kSystickEnable | kSystickCoreClock;
}

}  // namespace

void run_free(Controller& controller, ServoOutputs& outputs, std::int64_t period_ns) noexcept {
    uart_start(kBaud);
    start_tick_timer(period_ns);
    asm volatile("cpsie i" ::: "memory");
    ServoInputs inputs;
    for (;; ++inputs.tick) {
        while ((systick_control() & kSystickCounted) == 0) {
            queue.send_some();
        }
        inputs.link_rx = std::span<const std::uint8_t>(received).first(uart_take(received));
        recording::clear(outputs);
        controller.servo_step(inputs, outputs);
        queue.push(std::span<const std::uint8_t>(outputs.link_tx).first(outputs.link_tx_size));
        controller.plan_step(motion::kUnitsPerTick);
    }
}

}  // namespace sc::mps2_an500
