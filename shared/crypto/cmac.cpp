// SPDX-License-Identifier: Apache-2.0
#include "shared/crypto/cmac.hpp"

namespace sc::crypto {
namespace {

/// Times x in GF(2^128), by RFC 4493.
void double_block(Block& block) noexcept {
    const unsigned carry = block[0] >> 7U;
    for (std::size_t i = 0; i < block.size(); ++i) {
        const unsigned next = i + 1 < block.size() ? block[i + 1] >> 7U : 0U;
        block[i] = static_cast<std::uint8_t>((unsigned{block[i]} << 1U) | next);
    }
    block[15] = static_cast<std::uint8_t>(block[15] ^ (0x87U * carry));
}

}  // namespace

CmacKey::CmacKey(const Key& key) noexcept : aes_(key) {
    aes_.encrypt(subkey_);
    double_block(subkey_);
}

bool CmacRun::step(const CmacKey& key, std::span<const std::uint8_t> message) noexcept {
    const std::span<const std::uint8_t> rest = message.subspan(done_);
    const std::size_t size = rest.size() < state_.size() ? rest.size() : state_.size();
    for (std::size_t i = 0; i < size; ++i) {
        state_[i] ^= rest[i];
    }
    const bool ends = rest.size() <= state_.size();
    if (ends) {
        Block subkey = key.subkey_;
        if (size < state_.size()) {
            state_[size] ^= 0x80U;
            double_block(subkey);
        }
        for (std::size_t i = 0; i < state_.size(); ++i) {
            state_[i] ^= subkey[i];
        }
    }
    key.aes_.encrypt(state_);
    done_ += size;
    return ends;
}

Block cmac(const CmacKey& key, std::span<const std::uint8_t> message) noexcept {
    CmacRun run;
    run.begin();
    while (!run.step(key, message)) {
    }
    return run.tag();
}

}  // namespace sc::crypto
