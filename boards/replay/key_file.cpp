// SPDX-License-Identifier: Apache-2.0
#include "boards/replay/key_file.hpp"

#include <cerrno>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <system_error>

#include <sys/random.h>

#include "shared/crypto/key_text.hpp"

namespace sc::replay {

crypto::Key read_key_file(const std::filesystem::path& file) {
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (error || !fs::is_regular_file(status)) {
        throw std::invalid_argument(file.string() + ": is no file that could hold a key; make one with scribecell key");
    }
    if ((status.permissions() & (fs::perms::group_all | fs::perms::others_all)) != fs::perms::none) {
        throw std::invalid_argument(file.string() + ": others may read or write this key; chmod 600 it");
    }
    std::ifstream in(file);
    std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) {
        text.pop_back();
    }
    const auto key = crypto::key_from_text(text);
    if (!in || !key) {
        throw std::invalid_argument(file.string() + ":1: a key is one line of " + std::to_string(crypto::kKeyDigits) +
                                    " hex digits, this has " + std::to_string(text.size()) + " characters");
    }
    return *key;
}

link::SealSecret secret_of(const crypto::Key& key) {
    link::SealSecret secret;
    secret.key = key;
    if (::getrandom(secret.entropy.data(), secret.entropy.size(), 0) != static_cast<ssize_t>(secret.entropy.size())) {
        throw std::system_error(errno, std::generic_category(), "random numbers of the system");
    }
    return secret;
}

}  // namespace sc::replay
