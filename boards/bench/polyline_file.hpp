// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "firmware/trajectory/spec.hpp"

namespace sc::bench {

/// What is wrong with a file, with its name, line and value and what to do.
class FileError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// A polyline from CSV: header x,y,z or x,y,z,c; millimetres and degrees. Places in metres and degrees. Throws
/// FileError.
[[nodiscard]] std::vector<trajectory::Place> read_polyline(const std::filesystem::path& file);

}  // namespace sc::bench
