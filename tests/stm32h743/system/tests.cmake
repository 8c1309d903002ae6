# SPDX-License-Identifier: Apache-2.0
add_library(stm32h743_system_model STATIC ${CMAKE_CURRENT_LIST_DIR}/../model/clock_tree.cpp
  ${CMAKE_CURRENT_LIST_DIR}/../model/watchdogs.cpp ${CMAKE_CURRENT_LIST_DIR}/../model/core_faults.cpp
  ${CMAKE_CURRENT_LIST_DIR}/../model/core_memory.cpp ${CMAKE_CURRENT_LIST_DIR}/../model/interrupt_control.cpp)
target_link_libraries(stm32h743_system_model PRIVATE sc_warnings sc_sanitizers PUBLIC stm32h743_machine)
sc_test(stm32h743_system LABEL unit SOURCES ${CMAKE_CURRENT_LIST_DIR}/clock_registers_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/clock_start_test.cpp ${CMAKE_CURRENT_LIST_DIR}/watchdogs_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/fault_record_test.cpp ${CMAKE_CURRENT_LIST_DIR}/memory_start_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/interrupts_test.cpp
  DEPS boards_stm32h743_system stm32h743_system_model)
include("${CMAKE_CURRENT_LIST_DIR}/mutants.cmake")
