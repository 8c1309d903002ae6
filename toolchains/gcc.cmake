# SPDX-License-Identifier: Apache-2.0
# Debian 12's own compiler: GCC 12.
set(CMAKE_CXX_COMPILER g++)
