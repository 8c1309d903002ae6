# SPDX-License-Identifier: Apache-2.0
add_library(stm32h743_link_model STATIC ${CMAKE_CURRENT_LIST_DIR}/../model/can_wire.cpp
  ${CMAKE_CURRENT_LIST_DIR}/../model/fdcan.cpp ${CMAKE_CURRENT_LIST_DIR}/../model/byte_dma.cpp
  ${CMAKE_CURRENT_LIST_DIR}/../model/usart.cpp)
target_link_libraries(stm32h743_link_model PRIVATE sc_warnings sc_sanitizers PUBLIC stm32h743_machine)
sc_test(stm32h743_link LABEL unit SOURCES ${CMAKE_CURRENT_LIST_DIR}/fdcan_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/fdcan_registers_test.cpp ${CMAKE_CURRENT_LIST_DIR}/host_uart_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/usart_registers_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/sensor_port_test.cpp
  DEPS boards_stm32h743_link stm32h743_link_model firmware_sensors)
include("${CMAKE_CURRENT_LIST_DIR}/mutants.cmake")
