// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "host/inspection/inspection.hpp"

/// The pictures of a report: SVG elements. For the sources of this folder only.

namespace sc::host {

/// Text that may stand in HTML.
[[nodiscard]] std::string escaped(std::string_view text);
[[nodiscard]] std::string histogram_svg(const FaceAllowance& before, const FaceAllowance* after);
/// Mean and least metal on the sides along ±X, ±Y, ±Z.
[[nodiscard]] std::string sides_svg(const AllowanceReport& before, const AllowanceReport* after);
/// The CAD model's section in grey, the measured line in colour, gaps dashed.
[[nodiscard]] std::string section_svg(const DatumLine& line, const TriangleMesh& mesh);

}  // namespace sc::host
