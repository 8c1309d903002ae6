# SPDX-License-Identifier: Apache-2.0
# The tests of the other builds, each build one test of this one. ./test builds them first and sets SC_MATRIX.
if(NOT SC_MATRIX)
  return()
endif()
cmake_host_system_information(RESULT sc_cores QUERY NUMBER_OF_LOGICAL_CORES)

foreach(build clang asan)
  add_test(NAME matrix.${build} COMMAND "${CMAKE_CTEST_COMMAND}" --test-dir "${PROJECT_SOURCE_DIR}/build/${build}"
    --output-on-failure --no-tests=error -j ${sc_cores})
endforeach()
# GoogleTest is there for 64 bit only: this build is compiled, and its scribecell-replay runs in hashes.cmake.
add_test(NAME matrix.m32 COMMAND "${CMAKE_COMMAND}" --build "${PROJECT_SOURCE_DIR}/build/m32")
set_tests_properties(matrix.clang matrix.asan matrix.m32 PROPERTIES LABELS matrix RUN_SERIAL ON TIMEOUT 3600)
