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
# The image, when build/h743 was built: cmake --preset h743 && cmake --build --preset h743.
if(SC_H743)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  add_test(NAME h743.image COMMAND Python3::Interpreter -B ${CMAKE_CURRENT_LIST_DIR}/image.py "${PROJECT_SOURCE_DIR}/build/h743")
  set_tests_properties(h743.image PROPERTIES LABELS m7 TIMEOUT 60)
endif()
