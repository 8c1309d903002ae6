# SPDX-License-Identifier: Apache-2.0
# Programs of this build against the kernel interfaces of a guest in QEMU. ./test installs tier guest and sets SC_GUEST.
if(NOT SC_GUEST)
  return()
endif()
# Run by cases inside the guest, not by CTest.
function(sc_guest_program name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "" "SOURCES;DEPS")
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE sc_warnings sc_sanitizers ${ARG_DEPS} GTest::gtest GTest::gtest_main)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")
endfunction()

sc_guest_program(guest_socketcan
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/boards/socketcan/kernel_test.cpp
  DEPS boards_socketcan)

find_package(Python3 REQUIRED COMPONENTS Interpreter)
# The guest has two processors.
add_test(NAME guest.cases COMMAND Python3::Interpreter -B ${CMAKE_CURRENT_LIST_DIR}/guest.py ${PROJECT_BINARY_DIR}
  --json ${PROJECT_BINARY_DIR}/guest-cases.json)
set_tests_properties(guest.cases PROPERTIES LABELS guest TIMEOUT 1500 PROCESSORS 2)
