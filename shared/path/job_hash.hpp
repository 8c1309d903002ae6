// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "shared/hash/fnv.hpp"
#include "shared/path/item.hpp"

namespace sc {

/// Hash of a job: FNV-1a in steps of 32-bit words over its items in order, each as its block tag and then its fields
/// (of a path's begin, actuator and pass share a word: actuator + 256 · pass), so that it does not depend on how the
/// items were cut into blocks. Host and controller each make their own; JobOpen::job carries the host's.
class JobHasher {
public:
    JobHasher() noexcept = default;
    /// Goes on behind items whose hash is `before`.
    explicit JobHasher(std::uint64_t before) noexcept : hash_(before) {}
    /// At most ten steps. Any context.
    void add(const Item& item) noexcept;
    [[nodiscard]] std::uint64_t value() const noexcept { return hash_.value(); }

private:
    Fnv1a64 hash_;
};

[[nodiscard]] std::uint64_t job_hash(std::span<const Item> items) noexcept;

}  // namespace sc
