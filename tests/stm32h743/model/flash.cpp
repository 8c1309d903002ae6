// SPDX-License-Identifier: Apache-2.0
#include "tests/stm32h743/model/flash.hpp"

#include <algorithm>

namespace sc::model {
namespace {

constexpr std::uint32_t kLock = 0x01;
constexpr std::uint32_t kPg = 0x02;
constexpr std::uint32_t kSer = 0x04;
constexpr std::uint32_t kPsize = 0x30;
constexpr std::uint32_t kStart = 0x80;
constexpr std::uint32_t kSnb = 0x0700;
constexpr std::uint32_t kKnownControl = kLock | kPg | kSer | kPsize | kStart | kSnb;
constexpr std::uint32_t kBsy = 0x01;
constexpr std::uint32_t kWbne = 0x02;
constexpr std::uint32_t kQw = 0x04;
constexpr std::uint32_t kWrperr = 0x00020000;
constexpr std::uint32_t kPgserr = 0x00040000;
constexpr std::uint32_t kStrberr = 0x00080000;
constexpr std::uint32_t kIncerr = 0x00200000;
constexpr std::uint32_t kOperr = 0x00400000;
constexpr std::uint32_t kRdperr = 0x00800000;
constexpr std::uint32_t kRdserr = 0x01000000;
constexpr std::uint32_t kSneccerr = 0x02000000;
constexpr std::uint32_t kDbeccerr = 0x04000000;
constexpr std::uint32_t kErrors = kWrperr | kPgserr | kStrberr | kIncerr | kOperr | kRdperr | kRdserr;
constexpr std::uint32_t kClearable = 0x0FEF0000;
constexpr std::uint32_t kBankWords = Flash::kBytes / 2 / Flash::kWord;
constexpr std::uint32_t kSectorWords = Flash::kSector / Flash::kWord;

}  // namespace

const std::map<std::string, std::uint32_t> Flash::kMasks{
    {"FLASH_CR1.LOCK", kLock},
    {"FLASH_CR1.PG", kPg},
    {"FLASH_CR1.SER", kSer},
    {"FLASH_CR1.PSIZE", kPsize},
    {"FLASH_CR1.START", kStart},
    {"FLASH_CR1.SNB", kSnb},
    {"FLASH_SR1.BSY", kBsy},
    {"FLASH_SR1.WBNE", kWbne},
    {"FLASH_SR1.QW", kQw},
    {"FLASH_SR1.WRPERR", kWrperr},
    {"FLASH_SR1.PGSERR", kPgserr},
    {"FLASH_SR1.STRBERR", kStrberr},
    {"FLASH_SR1.INCERR", kIncerr},
    {"FLASH_SR1.OPERR", kOperr},
    {"FLASH_SR1.RDPERR", kRdperr},
    {"FLASH_SR1.RDSERR", kRdserr},
    {"FLASH_SR1.SNECCERR", kSneccerr},
    {"FLASH_SR1.DBECCERR", kDbeccerr},
};

Flash::Flash(Machine& machine)
    : machine_(machine),
      core_(machine, [this](std::uint32_t at) { cache_.erase((at - kArray) / kWord); }),
      cells_(kBytes, 0xFF),
      lost_(kBytes / kWord, false) {
    machine.attach(kRegisters, 0x200, registers_);
    machine.attach(kArray, kBytes, array_);
}

void Flash::power_on() {
    banks_ = {};
    cache_.clear();
    core_.reset();
    dead_ = false;
    left_ = -1;
    fail_ = 0;
}

std::uint32_t Flash::Registers::read(std::uint32_t offset) {
    Bank& bank = flash_.banks_.at(offset / kSecondBank);
    switch (offset % kSecondBank) {
        case kControl: return bank.control;
        case kStatus: return bank.status;
        default: flash_.machine_.violation("flash: a register that is not modelled is read"); return 0;
    }
}

void Flash::Registers::write(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (flash_.dead_) {
        return;
    }
    if (bytes != 4) {
        flash_.machine_.violation("flash: registers are words");
    }
    Bank& bank = flash_.banks_.at(offset / kSecondBank);
    switch (offset % kSecondBank) {
        case kKey: flash_.key(bank, value); break;
        case kControl: flash_.control(bank, value); break;
        case kClear:
            if ((value & ~kClearable) != 0) {
                flash_.machine_.violation("flash: reserved bits of CCR");
            }
            bank.status &= ~value;
            break;
        default: flash_.machine_.violation("flash: a register that is not modelled is written"); break;
    }
}

std::int64_t Flash::Registers::next_ns() const {
    return std::min(flash_.banks_[0].until_ns, flash_.banks_[1].until_ns);
}

void Flash::Registers::act(std::int64_t now_ns) {
    for (unsigned i = 0; i < 2; ++i) {
        if (flash_.banks_.at(i).until_ns <= now_ns) {
            flash_.end(flash_.banks_.at(i), i);
        }
    }
}

void Flash::key(Bank& bank, std::uint32_t value) {
    constexpr std::array<std::uint32_t, 2> kKeys{0x45670123, 0xCDEF89AB};
    if ((bank.control & kLock) == 0 || bank.shut || value != kKeys.at(bank.keys)) {
        machine_.violation("flash: a wrong key, or a key where none is wanted; locked until a reset");
        bank.shut = true;
        bank.control |= kLock;
        return;
    }
    if (++bank.keys == 2) {
        bank.keys = 0;
        bank.control &= ~kLock;
    }
}

void Flash::control(Bank& bank, std::uint32_t value) {
    if ((bank.control & kLock) != 0) {
        machine_.violation("flash: CR is written while it is locked");
        return;
    }
    if ((value & ~kKnownControl) != 0) {
        machine_.violation("flash: bits of CR that are reserved or not modelled");
    }
    if ((bank.status & (kBsy | kQw | kWbne)) != 0) {
        machine_.violation("flash: CR is written while its bank works");
        return;
    }
    if ((value & kPg) != 0 && (value & kSer) != 0) {
        machine_.violation("flash: erase and program at once");
        bank.status |= kPgserr;
        return;
    }
    if ((value & kStart) != 0) {
        // The sector and the request stand before the start.
        if ((value & kSer) == 0 || ((bank.control ^ value) & (kSnb | kSer | kPsize)) != 0) {
            machine_.violation("flash: a start without its request before it");
            bank.status |= kPgserr;
            return;
        }
        if ((bank.status & kErrors) != 0) {
            machine_.violation("flash: begun while the flags of an error stand");
        }
        bank.erasing = true;
        bank.control = value;
        begin(bank, erase_ns_);
        return;
    }
    bank.control = value;
}

std::uint32_t Flash::load(std::uint32_t offset) {
    const std::uint32_t word = offset / kWord;
    const auto part = static_cast<std::size_t>(offset % kWord / 4);
    if (const auto line = cache_.find(word); line != cache_.end()) {
        return line->second.at(part);
    }
    Bank& bank = banks_.at(word / kBankWords);
    if ((bank.status & (kBsy | kQw)) != 0) {
        machine_.violation("flash: read of a bank that works stalls the processor");
    }
    if (lost_.at(word)) {
        bank.status |= kDbeccerr;
        core_.bus_fault("a word of the flash that ECC cannot put right");
        return static_cast<std::uint32_t>(random_());
    }
    std::array<std::uint32_t, 8> line{};
    for (std::size_t i = 0; i < kWord; ++i) {
        line.at(i / 4) |= std::uint32_t{cells_.at(static_cast<std::size_t>(word) * kWord + i)} << (8 * (i % 4));
    }
    cache_[word] = line;
    return line.at(part);
}

void Flash::store(std::uint32_t offset, std::uint32_t value, unsigned bytes) {
    if (dead_) {
        return;
    }
    const std::uint32_t word = offset / kWord;
    Bank& bank = banks_.at(word / kBankWords);
    if (bytes != 4) {
        machine_.violation("flash: less than 32 bits at a time");
        return;
    }
    if ((bank.control & (kLock | kPg)) != kPg || (bank.status & kErrors) != 0) {
        machine_.violation("flash: written while locked, without PG, or while the flags of an error stand");
        bank.status |= kPgserr;
        return;
    }
    if ((bank.control & kPsize) != kPsize) {
        machine_.violation("flash: slower than the supply allows");
    }
    if ((bank.status & kQw) != 0) {
        machine_.violation("flash: written while its bank works");
        return;
    }
    if (bank.filled != 0 && bank.word != word) {
        machine_.violation("flash: another word is begun before the first one is whole");
        bank.status |= kIncerr;
        return;
    }
    const std::uint32_t bit = 1U << (offset % kWord / 4);
    if ((bank.filled & bit) != 0) {
        machine_.violation("flash: a part of a word is written twice");
        bank.status |= kStrberr;
        return;
    }
    bank.word = word;
    bank.filled |= bit;
    bank.buffer.at(offset % kWord / 4) = value;
    bank.status |= kWbne;
    if (bank.filled == 0xFF) {
        bank.status &= ~kWbne;
        bank.filled = 0;
        bank.erasing = false;
        if (!blank(word)) {
            machine_.violation("flash: a word is programmed that is not erased");
        }
        begin(bank, program_ns_);
    }
}

void Flash::begin(Bank& bank, std::int64_t duration_ns) {
    bank.status |= kBsy | kQw;
    bank.until_ns = machine_.now_ns() + duration_ns;
}

void Flash::end(Bank& bank, unsigned number) {
    bank.until_ns = Peripheral::kNever;
    bank.status &= ~(kBsy | kQw);
    bank.control &= ~kStart;
    if (dead_) {
        return;
    }
    if (fail_ != 0) {
        bank.status |= fail_;
        fail_ = 0;
        return;
    }
    ++works_;
    const bool now = left_ == 0;
    left_ -= left_ >= 0 ? 1 : 0;
    const Cut outcome = now ? outcome_ : Cut::whole;
    dead_ = now;
    if (bank.erasing) {
        erase(number * kBankWords + ((bank.control >> 8U) & 7U) * kSectorWords, outcome);
    } else {
        program(bank, outcome);
    }
}

void Flash::program(const Bank& bank, Cut outcome) {
    switch (outcome) {
        case Cut::untouched: return;
        case Cut::broken: lost_.at(bank.word) = true; return;
        case Cut::random:
        case Cut::mixed: scramble(bank.word); return;
        case Cut::whole: break;
    }
    if (!blank(bank.word)) {
        lost_.at(bank.word) = true;
        return;
    }
    for (std::size_t i = 0; i < kWord; ++i) {
        cells_.at(static_cast<std::size_t>(bank.word) * kWord + i) =
            static_cast<std::uint8_t>(bank.buffer.at(i / 4) >> (8 * (i % 4)));
    }
}

void Flash::erase(std::uint32_t first_word, Cut outcome) {
    for (std::uint32_t word = first_word; word < first_word + kSectorWords; ++word) {
        const auto kind = outcome == Cut::mixed ? static_cast<Cut>(random_() % 4) : outcome;
        switch (kind) {
            case Cut::untouched: break;
            case Cut::broken: lost_.at(word) = true; break;
            case Cut::random:
            case Cut::mixed: scramble(word); break;
            case Cut::whole:
                lost_.at(word) = false;
                std::fill_n(cells_.begin() + static_cast<std::ptrdiff_t>(word * kWord), kWord, std::uint8_t{0xFF});
                break;
        }
    }
}

void Flash::scramble(std::uint32_t word) {
    lost_.at(word) = false;
    std::generate_n(cells_.begin() + static_cast<std::ptrdiff_t>(word * kWord), kWord,
                    [&] { return static_cast<std::uint8_t>(random_()); });
}

bool Flash::blank(std::uint32_t word) const {
    const auto first = cells_.begin() + static_cast<std::ptrdiff_t>(word * kWord);
    return !lost_.at(word) && std::all_of(first, first + kWord, [](std::uint8_t byte) { return byte == 0xFF; });
}

}  // namespace sc::model
