// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace sc::host {

/// What an EMCY's error code says, by CiA 301 and CiA 402: the code itself where it is listed, else its group ("2xxx:
/// current"). 0: the error is gone. Codes FFxx are the maker's.
[[nodiscard]] std::string emergency_text(std::uint16_t code);
/// Bits of the error register 1001, as words; "" for none.
[[nodiscard]] std::string error_register_text(std::uint8_t bits);

}  // namespace sc::host
