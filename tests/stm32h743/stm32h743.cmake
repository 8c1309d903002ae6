# SPDX-License-Identifier: Apache-2.0
# Drivers of boards/stm32h743 against models of the chip's peripherals.
if(NOT SC_SIM)
  return()
endif()
add_library(stm32h743_machine STATIC ${CMAKE_CURRENT_LIST_DIR}/model/machine.cpp)
target_link_libraries(stm32h743_machine PRIVATE sc_warnings sc_sanitizers PUBLIC boards_stm32h743_registers)
target_include_directories(stm32h743_machine PUBLIC "${PROJECT_BINARY_DIR}/include/tests")
include("${CMAKE_CURRENT_LIST_DIR}/mutants.cmake")
file(GLOB sc_h743_tests CONFIGURE_DEPENDS "${CMAKE_CURRENT_LIST_DIR}/*/tests.cmake")
foreach(list IN LISTS sc_h743_tests)
  include("${list}")
endforeach()
