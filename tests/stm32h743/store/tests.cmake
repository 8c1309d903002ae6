# SPDX-License-Identifier: Apache-2.0
set(sc_h743_model "${CMAKE_CURRENT_LIST_DIR}/../model")
add_library(stm32h743_store_model STATIC "${sc_h743_model}/backup_ram.cpp" "${sc_h743_model}/core.cpp"
  "${sc_h743_model}/flash.cpp")
target_link_libraries(stm32h743_store_model PRIVATE sc_warnings sc_sanitizers PUBLIC stm32h743_machine)
sc_test(stm32h743_store LABEL unit SOURCES ${CMAKE_CURRENT_LIST_DIR}/backup_ram_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/flash_memory_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/flash_store_test.cpp ${CMAKE_CURRENT_LIST_DIR}/flash_parameters_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/registers_test.cpp ${CMAKE_CURRENT_LIST_DIR}/slots_test.cpp
  DEPS boards_stm32h743_store stm32h743_store_model firmware_store)
include("${CMAKE_CURRENT_LIST_DIR}/mutants.cmake")
