# SPDX-License-Identifier: Apache-2.0
# GCC for 32-bit x86. SSE2 arithmetic, because the x87 unit rounds to other bits.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR i686)
set(CMAKE_CXX_COMPILER g++)
set(CMAKE_CXX_FLAGS_INIT "-m32 -msse2 -mfpmath=sse")
