// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

/// Counts what a thread allocates while it must not. Programs that link this have malloc and its kin go through it: one
/// comparison more for each call.

namespace sc::linux_rt {

/// From its making to its end this thread must not allocate or free.
class NoAllocation {
public:
    NoAllocation() noexcept;
    ~NoAllocation();
    NoAllocation(const NoAllocation&) = delete;
    NoAllocation& operator=(const NoAllocation&) = delete;
};

/// Calls of malloc, calloc, realloc, free and aligned kinds in such stretches, of all threads.
[[nodiscard]] std::uint64_t forbidden_allocations() noexcept;

}  // namespace sc::linux_rt
