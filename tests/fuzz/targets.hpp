// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

/// The targets of the fuzzer: one for each decoder and each reader of files.

namespace sc::fuzz {

using Bytes = std::span<const std::uint8_t>;

struct Target {
    std::string_view name;
    void (*run)(Bytes input);
};

/// Decoders of wire bytes, then readers of files.
[[nodiscard]] std::span<const Target> wire_targets() noexcept;
[[nodiscard]] std::span<const Target> file_targets() noexcept;

/// Takes numbers and runs of bytes from the fuzzer's input; zeros and nothing at its end.
class Feed {
public:
    explicit Feed(Bytes input) noexcept : rest_(input) {}
    [[nodiscard]] bool empty() const noexcept { return rest_.empty(); }
    [[nodiscard]] std::uint8_t byte() noexcept { return rest_.empty() ? std::uint8_t{0} : take(1)[0]; }
    [[nodiscard]] Bytes take(std::size_t size) noexcept {
        const Bytes taken = rest_.first(size < rest_.size() ? size : rest_.size());
        rest_ = rest_.subspan(taken.size());
        return taken;
    }

private:
    Bytes rest_;
};

}  // namespace sc::fuzz
