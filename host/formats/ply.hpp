// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// PLY, for the sources of this folder only.

namespace sc::host {

/// What is wanted of a PLY file: places, the view each was seen from if it says so, and polygons if it has any.
struct PlyContent {
    std::vector<double> xyz;           ///< three a vertex; may hold NaN (a reader of clouds drops those)
    std::vector<std::uint32_t> view;   ///< one a vertex, or empty: property "view" or "scan" or "scan_id"
    std::vector<std::uint32_t> index;  ///< corners of triangles, three each (polygons cut into fans)
    std::size_t vertices = 0;
};

[[nodiscard]] bool looks_like_ply(std::string_view bytes) noexcept;
/// Throws InputError for a malformed header, an element that ends early, an index out of range.
[[nodiscard]] PlyContent parse_ply(const std::filesystem::path& file, std::string_view bytes);

}  // namespace sc::host
