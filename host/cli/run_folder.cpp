// SPDX-License-Identifier: Apache-2.0
#include "host/cli/run_folder.hpp"

#include <cerrno>
#include <string>
#include <system_error>

#include <stdlib.h>

#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

std::filesystem::path make_temporary() {
    std::string name = (std::filesystem::temp_directory_path() / "scribecell-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
        throw std::system_error(errno, std::generic_category(), "cannot make a folder for the run in " + name);
    }
    return name;
}

}  // namespace

RunFolder::RunFolder(const std::optional<std::filesystem::path>& named)
    : path_(named ? *named : make_temporary()), named_(named.has_value()) {
    std::error_code failed;
    std::filesystem::create_directories(path_, failed);
    if (!std::filesystem::is_directory(path_)) {
        throw InputError({.file = path_.string(),
                          .problem = "the output folder cannot be made",
                          .value = failed.message(),
                          .action = "name another with --out"});
    }
}

RunFolder::~RunFolder() {
    if (!named_) {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
}

}  // namespace sc::host::cli
