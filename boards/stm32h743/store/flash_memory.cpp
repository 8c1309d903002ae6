// SPDX-License-Identifier: Apache-2.0
#include "boards/stm32h743/store/flash_memory.hpp"

#include <algorithm>

#include "boards/stm32h743/registers/flash.hpp"
#include "boards/stm32h743/store/fault_guard.hpp"

namespace sc::stm32h743 {
namespace {

namespace regs = flash_registers;

constexpr std::uint32_t kAtWork = regs::kBusy | regs::kBufferNotEmpty | regs::kQueued;
constexpr std::uint32_t kErrors = regs::kWriteProtection | regs::kSequence | regs::kStrobe | regs::kInconsistency |
                                  regs::kOperation | regs::kReadProtection | regs::kSecure;
constexpr unsigned kSectorsOfBank = FlashMemory::kSectors / 2;
constexpr Address kBankBytes = static_cast<Address>(kSectorsOfBank * FlashMemory::kSectorBytes);

/// Of the bank in which this address is: what is added to the registers of bank 1.
Address bank_of(Address at) noexcept { return at < FlashMemory::kStart + kBankBytes ? 0 : regs::kBank2; }

bool is_word(Address at) noexcept {
    return at >= FlashMemory::kStart && at - FlashMemory::kStart < 2 * kBankBytes && at % FlashMemory::kWordBytes == 0;
}

}  // namespace

FlashMemory::Begin FlashMemory::unlock(Address bank) const noexcept {
    if (marking_) {
        return Begin::marking;
    }
    if (working() || (read32(regs::kSr + bank) & kAtWork) != 0) {
        return Begin::busy;
    }
    write32(regs::kCcr + bank, kErrors);
    if ((read32(regs::kCr + bank) & regs::kLock) != 0) {
        write32(regs::kKeyr + bank, regs::kFirstKey);
        write32(regs::kKeyr + bank, regs::kSecondKey);
    }
    return (read32(regs::kCr + bank) & regs::kLock) == 0 ? Begin::begun : Begin::locked;
}

FlashMemory::Begin FlashMemory::erase(unsigned sector) noexcept {
    if (sector >= kSectors) {
        return Begin::place;
    }
    const Address bank = bank_of(sector_start(sector));
    if (const Begin begin = unlock(bank); begin != Begin::begun) {
        return begin;
    }
    const std::uint32_t which = regs::kSectorErase | regs::kSize64 | ((sector % kSectorsOfBank) << regs::kSectorShift);
    write32(regs::kCr + bank, which);
    write32(regs::kCr + bank, which | regs::kStart);
    barrier();
    work_ = Work::erase;
    bank_ = bank;
    timed_ = false;
    return Begin::begun;
}

FlashMemory::Begin FlashMemory::program(Address at, const Word& bytes) noexcept {
    if (!is_word(at)) {
        return Begin::place;
    }
    if (marking_) {
        return Begin::marking;
    }
    Word there{};
    const Read read_now = working() ? Read::away : read(at, there);
    if (read_now == Read::away) {
        return Begin::busy;
    }
    if (read_now == Read::lost || !erased(there)) {
        return Begin::not_erased;
    }
    const Address bank = bank_of(at);
    if (const Begin begin = unlock(bank); begin != Begin::begun) {
        return begin;
    }
    write32(regs::kCr + bank, regs::kProgram | regs::kSize64);
    barrier();
    instruction_barrier();
    for (std::size_t i = 0; i < kWordBytes; i += 4) {
        const std::uint32_t value = std::uint32_t{bytes[i]} | std::uint32_t{bytes[i + 1]} << 8U |
                                    std::uint32_t{bytes[i + 2]} << 16U | std::uint32_t{bytes[i + 3]} << 24U;
        write32(at + static_cast<Address>(i), value);
    }
    barrier();
    work_ = Work::program;
    bank_ = bank;
    at_ = at;
    word_ = bytes;
    timed_ = false;
    return Begin::begun;
}

FlashMemory::Progress FlashMemory::step(std::uint32_t now_ms) noexcept {
    if (work_ == Work::none) {
        return Progress::idle;
    }
    if (!timed_) {
        timed_ = true;
        since_ms_ = now_ms;
    }
    const std::uint32_t flags = read32(regs::kSr + bank_);
    const bool at_work = (flags & kAtWork) != 0;
    if (at_work && (flags & kErrors) == 0) {
        if (now_ms - since_ms_ <= (work_ == Work::erase ? kEraseLimitMs : kProgramLimitMs)) {
            return Progress::working;
        }
    }
    const Work ended = work_;
    work_ = Work::none;
    failure_ = flags & kErrors;
    if (at_work) {
        return Progress::failed;
    }
    write32(regs::kCr + bank_, 0);
    write32(regs::kCr + bank_, regs::kLock);
    if (failure_ != 0 || (ended == Work::program && !reads_back())) {
        return Progress::failed;
    }
    return Progress::done;
}

FlashMemory::Read FlashMemory::read(Address at, Word& out) noexcept {
    if (!is_word(at)) {
        return Read::away;
    }
    const Address bank = bank_of(at);
    if ((read32(regs::kSr + bank) & kAtWork) != 0) {
        return Read::away;
    }
    write32(regs::kCcr + bank, regs::kDoubleError | regs::kSingleError);
    barrier();
    write32(regs::kDcimvac, at);
    barrier();
    {
        const FaultGuard guard;
        for (std::size_t i = 0; i < kWordBytes; i += 4) {
            const std::uint32_t value = read32(at + static_cast<Address>(i));
            for (std::size_t byte = 0; byte < 4; ++byte) {
                out[i + byte] = static_cast<std::uint8_t>(value >> (8U * byte));
            }
        }
    }
    if ((read32(regs::kSr + bank) & regs::kDoubleError) == 0) {
        return Read::good;
    }
    write32(regs::kCcr + bank, regs::kDoubleError);
    out.fill(0);
    return Read::lost;
}

bool FlashMemory::erased(const Word& word) noexcept {
    return std::ranges::all_of(word, [](std::uint8_t byte) { return byte == 0xFF; });
}

bool FlashMemory::reads_back() noexcept {
    Word there{};
    return read(at_, there) == Read::good && there == word_;
}

}  // namespace sc::stm32h743
