// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sc::host::cli {

inline constexpr int kDone = 0;
inline constexpr int kFailed = 1;    ///< the cell or the job failed
inline constexpr int kBadInput = 2;  ///< bad input or usage; nothing has moved
// 130: a person ended it (bridge/stop.hpp).

}  // namespace sc::host::cli
