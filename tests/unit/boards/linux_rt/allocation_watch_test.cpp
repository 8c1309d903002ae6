// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/allocation_watch.hpp"

#include <atomic>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace sc::linux_rt {
namespace {

/// Not optimised away.
volatile std::size_t size_asked = 100;

TEST(AllocationWatch, CountsWhatAWatchedThreadTakesAndGivesBack) {
    const std::uint64_t before = forbidden_allocations();
    auto kept = std::make_unique<std::vector<int>>(size_asked);
    EXPECT_EQ(forbidden_allocations(), before);
    {
        const NoAllocation watched;
        kept.reset();
    }
    EXPECT_EQ(forbidden_allocations(), before + 2);
    {
        const NoAllocation watched;
        const std::string text(size_asked, 'x');
        EXPECT_EQ(text.size(), 100U);
    }
    EXPECT_EQ(forbidden_allocations(), before + 4);
}

TEST(AllocationWatch, SeesTheCLibrarysOwnCalls) {
    const std::uint64_t before = forbidden_allocations();
    void* volatile place = nullptr;  // not optimised away
    {
        const NoAllocation watched;
        place = std::calloc(size_asked, 2);
        place = std::realloc(place, 3 * size_asked);
    }
    EXPECT_GE(forbidden_allocations(), before + 2);
    std::free(place);
}

TEST(AllocationWatch, OtherThreadsMay) {
    const std::uint64_t before = forbidden_allocations();
    std::atomic<int> step{0};
    std::thread other([&step] {
        while (step.load() == 0) {
        }
        const std::vector<int> numbers(size_asked);
        step.store(2);
    });
    {
        const NoAllocation watched;
        step.store(1);
        while (step.load() != 2) {
        }
    }
    other.join();
    EXPECT_EQ(forbidden_allocations(), before);
}

}  // namespace
}  // namespace sc::linux_rt
