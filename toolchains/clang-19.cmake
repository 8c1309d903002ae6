# SPDX-License-Identifier: Apache-2.0
# The suffix matters: Debian 12's clang without one is 14 and does not know C++23's std::expected.
set(CMAKE_CXX_COMPILER clang++-19)
