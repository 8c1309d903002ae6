# SPDX-License-Identifier: Apache-2.0
# Tests of the image for the Cortex-M7, in QEMU and as a file. They need build/m7, which is another build:
#   cmake --preset m7 && cmake --build --preset m7, then configure this one with -DSC_M7=ON. ./test does both.
if(NOT SC_M7)
  return()
endif()
find_package(Python3 REQUIRED COMPONENTS Interpreter)
set(sc_m7_build "${PROJECT_SOURCE_DIR}/build/m7")
set(sc_m7_image "${sc_m7_build}/bin/scribecell-mps2-an500.elf")

sc_test(m7_board LABEL m7 TIMEOUT 300
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/boards/mps2_an500/counter_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/boards/mps2_an500/failure_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/boards/mps2_an500/lock_step_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/boards/mps2_an500/uart_test.cpp
          ${PROJECT_SOURCE_DIR}/tests/sim/firmware/controller/cell_rig.cpp
  DEPS boards_mps2_an500_pc boards_sim firmware_recording shared_hash shared_link)
target_compile_definitions(m7_board PRIVATE SC_M7_IMAGE="${sc_m7_image}")

if(SC_HOST)
  sc_test(m7_scribe LABEL m7 TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/scribe_m7_test.cpp ${PROJECT_SOURCE_DIR}/tests/sim/host/cli/program.cpp
    DEPS nlohmann_json::nlohmann_json)
  target_compile_definitions(m7_scribe PRIVATE SC_M7_IMAGE="${sc_m7_image}")
  add_dependencies(m7_scribe scribecell scribecell-cell)
  add_test(NAME m7.budgets COMMAND Python3::Interpreter -B ${CMAKE_CURRENT_LIST_DIR}/budgets.py $<TARGET_FILE:scribecell>)
  set_tests_properties(m7.budgets PROPERTIES LABELS m7 TIMEOUT 300)
endif()

foreach(check symbols sizes frames)
  add_test(NAME m7.${check} COMMAND Python3::Interpreter -B ${CMAKE_CURRENT_LIST_DIR}/image.py ${check} "${sc_m7_build}")
  set_tests_properties(m7.${check} PROPERTIES LABELS m7 TIMEOUT 60)
endforeach()
