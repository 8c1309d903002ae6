# SPDX-License-Identifier: Apache-2.0
if(SC_SIM)
  sc_test(sim_boards_rs485 LABEL sim TIMEOUT 120
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/boards/rs485/foreign_slave_test.cpp
      ${CMAKE_CURRENT_LIST_DIR}/boards/rs485/modbus_port_test.cpp
    DEPS boards_rs485 boards_sim_sensors boards_sim_world firmware_sensors shared_machine PkgConfig::MODBUS)
endif()
