# SPDX-License-Identifier: Apache-2.0
add_library(stm32h743_store_model STATIC ${CMAKE_CURRENT_LIST_DIR}/../model/flash.cpp)
target_link_libraries(stm32h743_store_model PRIVATE sc_warnings sc_sanitizers PUBLIC stm32h743_machine)
sc_test(stm32h743_store LABEL unit SOURCES ${CMAKE_CURRENT_LIST_DIR}/flash_memory_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/flash_store_test.cpp ${CMAKE_CURRENT_LIST_DIR}/flash_parameters_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/registers_test.cpp DEPS boards_stm32h743_store stm32h743_store_model firmware_store)
include("${CMAKE_CURRENT_LIST_DIR}/mutants.cmake")
