// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "host/formats/mesh.hpp"

namespace sc::host::cli {

/// read_mesh, and STEP besides, by the program scribecell-step (its unit is that of the file). Throws InputError; for
/// STEP without Open CASCADE it names the package.
[[nodiscard]] MeshFile read_cad(const std::filesystem::path& path, const LengthUnit& unit);

}  // namespace sc::host::cli
