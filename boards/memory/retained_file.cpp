// SPDX-License-Identifier: Apache-2.0
#include "boards/memory/retained_file.hpp"

#include <cerrno>
#include <system_error>
#include <type_traits>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace sc::memory {
namespace {

static_assert(std::is_trivially_copyable_v<RetainedMemory>, "the file holds its bytes");

[[noreturn]] void fail(const std::filesystem::path& path) {
    throw std::system_error(errno, std::generic_category(), path.string());
}

}  // namespace

RetainedFile::RetainedFile(const std::filesystem::path& path) {
    if (path.empty()) {
        return;
    }
    if (path.has_parent_path()) {
        std::filesystem::create_directories(path.parent_path());
    }
    const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (file < 0) {
        fail(path);
    }
    // New bytes are zero, which is a memory that was never written.
    void* mapped = MAP_FAILED;
    if (::ftruncate(file, sizeof(RetainedMemory)) == 0) {
        mapped = ::mmap(nullptr, sizeof(RetainedMemory), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    }
    const int error = errno;
    ::close(file);
    if (mapped == MAP_FAILED) {
        errno = error;
        fail(path);
    }
    memory_ = static_cast<RetainedMemory*>(mapped);
}

RetainedFile::~RetainedFile() {
    if (memory_ != &local_) {
        ::munmap(memory_, sizeof(RetainedMemory));
    }
}

}  // namespace sc::memory
