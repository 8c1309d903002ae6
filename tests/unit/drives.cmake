# SPDX-License-Identifier: Apache-2.0
sc_test(unit_firmware_drives LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/drives/axis402_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/drives/bus_budget_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/drives/canopen_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/drives/drive_configuration_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/drives/drive_master_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/drives/drive_node_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/drives/sdo_client_test.cpp
  DEPS firmware_drives)
if(SC_SIM)
  sc_test(unit_boards_sim_drive LABEL unit
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/boards/sim/plant/drive_objects_test.cpp
      ${CMAKE_CURRENT_LIST_DIR}/boards/sim/plant/drive_servo_test.cpp
      ${CMAKE_CURRENT_LIST_DIR}/boards/sim/plant/drive_states_test.cpp
      ${CMAKE_CURRENT_LIST_DIR}/boards/sim/plant/drive_test.cpp
    DEPS boards_sim_plant)
endif()
