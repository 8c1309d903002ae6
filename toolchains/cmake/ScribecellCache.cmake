# SPDX-License-Identifier: Apache-2.0
# ccache, if it is there. Paths below the project are hashed relative to the build folder: another clone, or another build
# folder with the same flags, hits the same entries.
find_program(SC_CCACHE ccache)
mark_as_advanced(SC_CCACHE)
if(SC_CCACHE AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CMAKE_COMMAND}" -E env "CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}" CCACHE_NOHASHDIR=1
    "${SC_CCACHE}")
endif()
