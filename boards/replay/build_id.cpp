// SPDX-License-Identifier: Apache-2.0
#include "boards/replay/build_id.hpp"

namespace sc::replay {

std::string build_id() {
#if defined(__clang__)
    const std::string compiler = "clang " + std::to_string(__clang_major__);
#else
    const std::string compiler = "gcc " + std::to_string(__GNUC__);
#endif
    const std::string bits = std::to_string(8 * sizeof(void*)) + " bit";
    return SC_VERSION " " SC_COMMIT " " + compiler + " " + bits;
}

}  // namespace sc::replay
