// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sc::host {

/// The frames of classic CAN: the header of each, the head of a message in its first frame, and the fields that lie
/// whole within that frame, by the message's number (extended multiplexing).
[[nodiscard]] std::string frames_dbc();

/// The messages, put together again: one `BO_` each, its fields at their bits. Its identifier is no frame's: the
/// frames' identifier times 256 plus the message's number, extended. What stands behind a run of bytes has no fixed
/// place, and is left out with a comment that says so.
[[nodiscard]] std::string messages_dbc();

}  // namespace sc::host
