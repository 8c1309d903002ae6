# SPDX-License-Identifier: Apache-2.0
sc_test(unit_firmware_sensors LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/sensors/bus_master_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/sensors/modbus_rtu_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/sensors/reading_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/sensors/surface_test.cpp
  DEPS firmware_sensors)
