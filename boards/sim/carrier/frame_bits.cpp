// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/carrier/frame_bits.hpp"

namespace sc::sim {
namespace {

constexpr int kIdBits = 11;
constexpr int kStuffRun = 5;
constexpr unsigned kCrc15 = 0x4599;
/// CRC delimiter, acknowledge and its delimiter, end of frame, interframe space.
constexpr int kClassicTail = 1 + 2 + 7 + 3;
constexpr int kFdNominalTail = 2 + 7 + 3;

/// Takes a frame's bits one by one; counts them with the stuff bits that they need, and makes the classic CRC.
class BitCounter {
public:
    void put(bool bit) noexcept {
        const bool next = bit != ((crc_ & 0x4000U) != 0);
        crc_ = (crc_ << 1U) & 0x7FFFU;
        crc_ ^= next ? kCrc15 : 0U;
        wire(bit);
    }
    void put(unsigned value, int bits) noexcept {
        for (int i = bits - 1; i >= 0; --i) {
            put(((value >> static_cast<unsigned>(i)) & 1U) != 0);
        }
    }
    void put_crc() noexcept {
        const unsigned crc = crc_;
        for (int i = 14; i >= 0; --i) {
            wire(((crc >> static_cast<unsigned>(i)) & 1U) != 0);
        }
    }
    [[nodiscard]] int count() const noexcept { return count_; }

private:
    void wire(bool bit) noexcept {
        ++count_;
        run_ = bit == last_ ? run_ + 1 : 1;
        last_ = bit;
        if (run_ == kStuffRun) {
            ++count_;
            last_ = !bit;
            run_ = 1;
        }
    }
    unsigned crc_ = 0;
    int count_ = 0;
    int run_ = 0;
    bool last_ = true;
};

unsigned dlc_of(std::size_t size) noexcept {
    constexpr std::array<std::uint8_t, 7> kSizes{12, 16, 20, 24, 32, 48, 64};
    if (size <= 8) {
        return static_cast<unsigned>(size);
    }
    unsigned dlc = 9;
    for (const std::uint8_t legal : kSizes) {
        if (size <= legal) {
            return dlc;
        }
        ++dlc;
    }
    return 15;
}

}  // namespace

FrameBits frame_bits(const link::LinkCanFrame& frame) noexcept {
    BitCounter bits;
    bits.put(false);  // start of frame
    bits.put(frame.id, kIdBits);
    if (!frame.fd) {
        bits.put(0, 3);  // RTR, IDE, reserved
        bits.put(dlc_of(frame.size), 4);
        for (std::size_t i = 0; i < frame.size; ++i) {
            bits.put(frame.data[i], 8);
        }
        bits.put_crc();
        return {bits.count() + kClassicTail, 0};
    }
    bits.put(0, 2);  // RRS, IDE
    bits.put(true);  // FDF
    bits.put(false);
    bits.put(true);  // bit-rate switch
    const int before = bits.count();
    bits.put(false);  // ESI
    bits.put(dlc_of(frame.size), 4);
    for (std::size_t i = 0; i < frame.size; ++i) {
        bits.put(frame.data[i], 8);
    }
    const bool short_crc = frame.size <= 16;
    const int crc = short_crc ? 17 + 6 : 21 + 7;
    constexpr int kStuffCount = 4;
    constexpr int kDelimiter = 1;
    return {before + kFdNominalTail, bits.count() - before + kStuffCount + crc + kDelimiter};
}

std::int64_t frame_ns(const link::LinkCanFrame& frame, const CanRates& rates) noexcept {
    constexpr std::int64_t kSecond = 1'000'000'000;
    const FrameBits bits = frame_bits(frame);
    const auto up = [](std::int64_t count, std::uint32_t rate) {
        return (count * kSecond + std::int64_t{rate} - 1) / std::int64_t{rate};
    };
    return up(bits.nominal, rates.nominal) + (bits.data > 0 ? up(bits.data, rates.data) : 0);
}

}  // namespace sc::sim
