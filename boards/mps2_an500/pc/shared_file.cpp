// SPDX-License-Identifier: Apache-2.0
#include "boards/mps2_an500/pc/shared_file.hpp"

#include <cerrno>
#include <new>
#include <system_error>

#include <sys/mman.h>
#include <unistd.h>

namespace sc::mps2_an500 {

SharedFile::SharedFile() {
    // Inherited by the child on purpose: it opens its own copy by the number.
    file_ = ::memfd_create("scribecell-m7-psram", 0);
    if (file_ < 0 || ::ftruncate(file_, kSharedRamFileBytes) != 0) {
        throw std::system_error(errno, std::generic_category(), "memory to share with QEMU");
    }
    void* memory = ::mmap(nullptr, kSharedRamFileBytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
    if (memory == MAP_FAILED) {
        const int number = errno;
        ::close(file_);
        throw std::system_error(number, std::generic_category(), "memory to share with QEMU");
    }
    ram_ = ::new (memory) SharedRam;
}

SharedFile::~SharedFile() {
    ::munmap(ram_, kSharedRamFileBytes);
    ::close(file_);
}

std::string SharedFile::path() const { return "/proc/self/fd/" + std::to_string(file_); }

}  // namespace sc::mps2_an500
