// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/key_file.hpp"

#include <cerrno>
#include <cstdio>
#include <system_error>

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/bridge/unique_fd.hpp"
#include "host/formats/error.hpp"
#include "shared/crypto/key_text.hpp"
#include "shared/link/seal.hpp"

namespace sc::host {
namespace {

constexpr const char* kHowToMake = "make one with scribecell key --out FILE, and give it to the cell too";

[[noreturn]] void refuse(const std::filesystem::path& file, int line, const std::string& problem,
                         const std::string& value, const std::string& action) {
    throw InputError({.file = file.string(), .line = line, .problem = problem, .value = value, .action = action});
}

void check_mode(const std::filesystem::path& file, int fd) {
    struct stat info{};
    if (::fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
        refuse(file, 0, "is no file that could hold a key", {}, kHowToMake);
    }
    constexpr mode_t kOthers = S_IRWXG | S_IRWXO;
    if ((info.st_mode & kOthers) != 0) {
        std::array<char, 8> mode{};
        std::snprintf(mode.data(), mode.size(), "%04o", static_cast<unsigned>(info.st_mode & 07777U));
        refuse(file, 0, "others may read or write this key, mode", mode.data(),
               "chmod 600 it, and make a new key if anybody may have read it");
    }
}

std::string text_of(const crypto::Key& key) {
    std::string text;
    for (const std::uint8_t byte : key) {
        std::array<char, 3> digits{};
        std::snprintf(digits.data(), digits.size(), "%02x", unsigned{byte});
        text += digits.data();
    }
    return text + "\n";
}

}  // namespace

crypto::Key read_key_file(const std::filesystem::path& file) {
    const UniqueFd fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
    if (fd.get() < 0) {
        refuse(file, 0, "the key cannot be read", std::generic_category().message(errno), kHowToMake);
    }
    check_mode(file, fd.get());
    std::array<char, 4 * crypto::kKeyDigits> buffer{};
    const ssize_t size = ::read(fd.get(), buffer.data(), buffer.size());
    std::string text(buffer.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
    const std::size_t end = text.find('\n');
    const std::string rest = end == std::string::npos ? "" : text.substr(end + 1);
    text.resize(std::min(end, text.size()));
    if (!text.empty() && text.back() == '\r') {
        text.pop_back();
    }
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (!crypto::hex_digit(text[i])) {
            refuse(file, 1, "a key has hex digits alone; column", std::to_string(i + 1), kHowToMake);
        }
    }
    const auto key = crypto::key_from_text(text);
    if (!key) {
        refuse(file, 1, "a key has " + std::to_string(crypto::kKeyDigits) + " hex digits, this line",
               std::to_string(text.size()), kHowToMake);
    }
    if (rest.find_first_not_of(" \t\r\n") != std::string::npos) {
        refuse(file, 2, "a key has one line", {}, kHowToMake);
    }
    return *key;
}

std::array<std::uint8_t, 16> random_bytes() {
    std::array<std::uint8_t, 16> bytes{};
    if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
        throw std::system_error(errno, std::generic_category(), "random numbers of the system");
    }
    return bytes;
}

crypto::Key make_key_file(const std::filesystem::path& file) {
    const crypto::Key key = random_bytes();
    // A new name beside it, whole before it gets its own; link() fails where rename() would replace.
    std::filesystem::path part = file;
    part += ".part" + std::to_string(::getpid());
    const std::string text = text_of(key);
    bool written = false;
    {
        const UniqueFd fd(::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR));
        if (fd.get() < 0) {
            refuse(file, 0, "cannot be written", std::generic_category().message(errno), "use another place");
        }
        written =
            ::write(fd.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size()) && ::fsync(fd.get()) == 0;
    }
    int error = errno;
    const bool placed = written && ::link(part.c_str(), file.c_str()) == 0;
    error = written ? errno : error;
    ::unlink(part.c_str());
    if (!placed && error == EEXIST) {
        refuse(file, 0, "is there already, and a key is never written over", {}, "use another name, or remove it");
    }
    if (!placed) {
        throw std::system_error(error, std::generic_category(), "writing " + file.string());
    }
    return key;
}

std::string key_check_text(const crypto::Key& key) {
    std::array<char, 9> text{};
    std::snprintf(text.data(), text.size(), "%08x", link::seal_key_check(key));
    return text.data();
}

}  // namespace sc::host
