# SPDX-License-Identifier: Apache-2.0
add_library(stm32h743_optics_model STATIC ${CMAKE_CURRENT_LIST_DIR}/../model/optics.cpp
  ${CMAKE_CURRENT_LIST_DIR}/../model/advanced_timer.cpp ${CMAKE_CURRENT_LIST_DIR}/../model/external_lines.cpp ${CMAKE_CURRENT_LIST_DIR}/../model/slow_lines.cpp
  ${CMAKE_CURRENT_LIST_DIR}/../model/status_spi.cpp)
target_link_libraries(stm32h743_optics_model PRIVATE sc_warnings sc_sanitizers PUBLIC stm32h743_machine)
sc_test(stm32h743_optics LABEL unit SOURCES ${CMAKE_CURRENT_LIST_DIR}/galvo_wave_test.cpp ${CMAKE_CURRENT_LIST_DIR}/registers_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pulse_segments_test.cpp ${CMAKE_CURRENT_LIST_DIR}/gate_wave_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gate_registers_test.cpp ${CMAKE_CURRENT_LIST_DIR}/safety_lines_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/lines_registers_test.cpp ${CMAKE_CURRENT_LIST_DIR}/guard_gate_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/power_strobes_test.cpp ${CMAKE_CURRENT_LIST_DIR}/galvo_status_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/power_registers_test.cpp
  DEPS boards_stm32h743_optics stm32h743_optics_model firmware_safety)
include("${CMAKE_CURRENT_LIST_DIR}/mutants.cmake")
