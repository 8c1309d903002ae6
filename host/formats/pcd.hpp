// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// PCD 0.7 (Point Cloud Library), for the sources of this folder only.

namespace sc::host {

[[nodiscard]] bool looks_like_pcd(std::string_view bytes) noexcept;
/// x, y, z of every point, three each; may hold NaN. Throws InputError.
[[nodiscard]] std::vector<double> parse_pcd(const std::filesystem::path& file, std::string_view bytes);
/// LZF as PCD's binary_compressed uses it. Empty if `packed` is damaged or does not give exactly `size` bytes.
[[nodiscard]] std::string unpacked_lzf(std::string_view packed, std::size_t size);

}  // namespace sc::host
