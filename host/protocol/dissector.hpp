// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sc::host {

/// A dissector for Wireshark and tshark, in Lua: the table of messages, then what works on it (dissector_runtime.cpp).
[[nodiscard]] std::string wireshark_dissector();

/// The part that knows of no message: framing, checksum, counters, trees.
[[nodiscard]] const char* dissector_runtime() noexcept;

}  // namespace sc::host
