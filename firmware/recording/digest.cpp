// SPDX-License-Identifier: Apache-2.0
#include "firmware/recording/digest.hpp"

#include "shared/hash/crc.hpp"
#include "shared/wire/bytes.hpp"

namespace sc::recording {

OutputsDigest OutputsDigester::digest(const ServoOutputs& outputs) noexcept {
    OutputPartEnds ends{};
    size_ = pack(outputs, image_, ends);
    OutputsDigest digest;
    digest.state = outputs.state;
    digest.faults = outputs.faults;
    std::array<std::uint8_t, kOutputParts * sizeof(std::uint32_t)> sums{};
    ByteWriter writer(sums);
    std::size_t begin = 0;
    for (std::size_t part = 0; part < kOutputParts; ++part) {
        const std::uint32_t sum = crc32(std::span(image_).subspan(begin, ends[part] - begin));
        begin = ends[part];
        digest.check[part] = static_cast<std::uint8_t>(sum & 0xFFU);
        writer.put(sum);
    }
    digest.crc = crc32(sums);
    return digest;
}

}  // namespace sc::recording
