// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/allocation_watch.hpp"

#include <atomic>
#include <cerrno>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__)
#define SC_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SC_ADDRESS_SANITIZER 1
#endif
#endif
#ifdef SC_ADDRESS_SANITIZER
#include <sanitizer/allocator_interface.h>
#endif

namespace sc::linux_rt {
namespace {

std::atomic<std::uint64_t> forbidden{0};
thread_local bool watched = false;

void note() noexcept {
    if (watched) {
        forbidden.fetch_add(1, std::memory_order_relaxed);
    }
}

#ifdef SC_ADDRESS_SANITIZER
// The sanitizer has put its own allocator in the place of the library's, and tells of each call.
void on_malloc(const volatile void* /*place*/, std::size_t /*size*/) { note(); }
void on_free(const volatile void* place) {
    if (place != nullptr) {
        note();
    }
}
const int installed = __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);
#endif

}  // namespace

NoAllocation::NoAllocation() noexcept { watched = true; }
NoAllocation::~NoAllocation() { watched = false; }

std::uint64_t forbidden_allocations() noexcept {
#ifdef SC_ADDRESS_SANITIZER
    static_cast<void>(installed);
#endif
    return forbidden.load(std::memory_order_relaxed);
}

}  // namespace sc::linux_rt

#ifndef SC_ADDRESS_SANITIZER
// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp,readability-identifier-naming): the C library's
// own names for its allocator
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* place, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* place);

void* malloc(std::size_t size) {
    sc::linux_rt::note();
    return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
    sc::linux_rt::note();
    return __libc_calloc(count, size);
}
void* realloc(void* place, std::size_t size) {
    sc::linux_rt::note();
    return __libc_realloc(place, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
    sc::linux_rt::note();
    return __libc_memalign(alignment, size);
}
int posix_memalign(void** place, std::size_t alignment, std::size_t size) {
    sc::linux_rt::note();
    *place = __libc_memalign(alignment, size);
    return *place == nullptr ? ENOMEM : 0;
}
void free(void* place) {
    if (place != nullptr) {
        sc::linux_rt::note();
    }
    __libc_free(place);
}
}
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp,readability-identifier-naming)
#endif
