// SPDX-License-Identifier: Apache-2.0
// The SDO server of ObjectDictionary (CiA 301, 7.2.4).
#include <algorithm>

#include "boards/sim/plant/drive_objects.hpp"

namespace sc::sim {
namespace {

using Frame = std::array<std::uint8_t, 8>;

constexpr std::uint32_t kOk = 0;
constexpr std::uint32_t kBadToggle = 0x0503'0000;
constexpr std::uint32_t kBadCommand = 0x0504'0001;
constexpr std::uint32_t kReadOnly = 0x0601'0002;
constexpr std::uint32_t kNoObject = 0x0602'0000;
constexpr std::uint32_t kBadLength = 0x0607'0010;
constexpr std::uint32_t kTooLong = 0x0607'0012;
constexpr std::uint32_t kNoSubIndex = 0x0609'0011;
constexpr std::size_t kLongestText = 64;
constexpr std::size_t kSegment = 7;
constexpr unsigned kToggleBit = 0x10;

std::uint32_t little_endian(const Frame& bytes, std::size_t at, std::size_t count) noexcept {
    std::uint32_t value = 0;
    for (std::size_t i = count; i > 0; --i) {
        value = (value << 8U) | bytes.at(at + i - 1);
    }
    return value;
}

Frame answer(unsigned command, const Frame& request, std::uint32_t value) noexcept {
    return {static_cast<std::uint8_t>(command),
            request[1],
            request[2],
            request[3],
            static_cast<std::uint8_t>(value),
            static_cast<std::uint8_t>(value >> 8U),
            static_cast<std::uint8_t>(value >> 16U),
            static_cast<std::uint8_t>(value >> 24U)};
}
Frame abort(const Frame& request, std::uint32_t code) noexcept { return answer(0x80, request, code); }
Frame abort(std::uint16_t index, std::uint32_t code) noexcept {
    return answer(0x80, {0, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8U)}, code);
}

}  // namespace

ObjectDictionary::Text* ObjectDictionary::find_text(std::uint16_t index) noexcept {
    const auto found = std::ranges::find(texts_, index, &Text::index);
    return found == texts_.end() ? nullptr : &*found;
}

std::string ObjectDictionary::text(std::uint16_t index) const {
    const auto found = std::ranges::find(texts_, index, &Text::index);
    return found == texts_.end() ? std::string() : found->value;
}

Frame ObjectDictionary::serve(const Frame& request) {
    const auto index = static_cast<std::uint16_t>(little_endian(request, 1, 2));
    const unsigned command = request[0];
    switch (command >> 5U) {
        case 0: return download_segment(request);
        case 3: return upload_segment(request);
        case 4: transferring_ = false; return {};
        default: break;
    }
    const bool upload = command == 0x40;
    const bool download = (command & 0xF3U) == 0x23U || (command & 0xFEU) == 0x20U || command == 0x22U;
    if (!upload && !download) {
        return abort(request, kBadCommand);
    }
    transferring_ = false;
    if (Text* const text = find_text(index)) {
        if (request[3] != 0) {
            return abort(request, kNoSubIndex);
        }
        return upload ? begin_upload(*text, request) : begin_download(*text, request);
    }
    Entry* entry = find(index, request[3]);
    if (entry == nullptr) {
        return abort(request, has_index(index) ? kNoSubIndex : kNoObject);
    }
    const unsigned unused = 4U - entry->size;
    if (upload) {
        return answer(0x43U | (unused << 2U), request, entry->value);
    }
    if ((command & 2U) == 0) {
        return abort(request, kBadCommand);  // numbers go expedited only
    }
    // 22 leaves open how many bytes count.
    if ((command & 1U) != 0 && ((command >> 2U) & 3U) != unused) {
        return abort(request, kBadLength);
    }
    const std::uint32_t value = little_endian(request, 4, entry->size);
    if (const std::uint32_t refused = check_write(*entry, value); refused != kOk) {
        return abort(request, refused);
    }
    entry->value = value;
    return answer(0x60, request, 0);
}

Frame ObjectDictionary::begin_upload(Text& text, const Frame& request) {
    if (text.value.size() <= 4) {
        Frame reply = answer(0x43U | static_cast<unsigned>((4 - text.value.size()) << 2U), request, 0);
        std::ranges::copy(text.value, reply.begin() + 4);
        return reply;
    }
    transfer_ = {.index = text.index, .upload = true, .toggle = false, .at = 0, .bytes = text.value};
    transferring_ = true;
    return answer(0x41, request, static_cast<std::uint32_t>(text.value.size()));
}

Frame ObjectDictionary::begin_download(Text& text, const Frame& request) {
    if (text.access == Access::read_only) {
        return abort(request, kReadOnly);
    }
    const unsigned command = request[0];
    if ((command & 2U) != 0) {
        const std::size_t size = (command & 1U) != 0 ? 4U - ((command >> 2U) & 3U) : 4U;
        text.value.assign(request.begin() + 4, request.begin() + 4 + static_cast<std::ptrdiff_t>(size));
        return answer(0x60, request, 0);
    }
    if ((command & 1U) != 0 && little_endian(request, 4, 4) > kLongestText) {
        return abort(request, kTooLong);
    }
    transfer_ = {.index = text.index, .upload = false, .toggle = false, .at = 0, .bytes = {}};
    transferring_ = true;
    return answer(0x60, request, 0);
}

Frame ObjectDictionary::upload_segment(const Frame& request) {
    if (!transferring_ || !transfer_.upload) {
        return abort(std::uint16_t{0}, kBadCommand);
    }
    const bool toggle = (request[0] & kToggleBit) != 0;
    if (toggle != transfer_.toggle) {
        transferring_ = false;
        return abort(transfer_.index, kBadToggle);
    }
    transfer_.toggle = !toggle;
    const std::size_t count = std::min(kSegment, transfer_.bytes.size() - transfer_.at);
    const bool last = transfer_.at + count == transfer_.bytes.size();
    Frame reply{static_cast<std::uint8_t>((toggle ? kToggleBit : 0U) | ((kSegment - count) << 1U) | (last ? 1U : 0U))};
    std::copy_n(transfer_.bytes.begin() + static_cast<std::ptrdiff_t>(transfer_.at), count, reply.begin() + 1);
    transfer_.at += count;
    transferring_ = !last;
    return reply;
}

Frame ObjectDictionary::download_segment(const Frame& request) {
    if (!transferring_ || transfer_.upload) {
        return abort(std::uint16_t{0}, kBadCommand);
    }
    const unsigned command = request[0];
    const bool toggle = (command & kToggleBit) != 0;
    const std::size_t count = kSegment - ((command >> 1U) & 7U);
    if (toggle != transfer_.toggle || transfer_.bytes.size() + count > kLongestText) {
        transferring_ = false;
        return abort(transfer_.index, toggle != transfer_.toggle ? kBadToggle : kTooLong);
    }
    transfer_.toggle = !toggle;
    transfer_.bytes.append(request.begin() + 1, request.begin() + 1 + static_cast<std::ptrdiff_t>(count));
    if ((command & 1U) != 0) {
        transferring_ = false;
        if (Text* const text = find_text(transfer_.index)) {
            text->value = transfer_.bytes;
        }
    }
    return {static_cast<std::uint8_t>(0x20U | (toggle ? kToggleBit : 0U))};
}

}  // namespace sc::sim
