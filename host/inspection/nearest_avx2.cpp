// SPDX-License-Identifier: Apache-2.0
#define SC_KERNEL kernel_avx2
#define SC_LANES 4
#include "host/inspection/nearest_kernel.hpp"

namespace sc::host {

void nearest_avx2(const NearestTree& tree, std::span<const Vec3> places, std::span<NearestSlot> out,
                  std::uint32_t& seed) {
    SC_KERNEL::nearest(tree, places, out, seed);
}

}  // namespace sc::host
