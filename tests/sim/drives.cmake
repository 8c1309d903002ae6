# SPDX-License-Identifier: Apache-2.0
if(SC_SIM)
  sc_test(sim_firmware_drives LABEL sim
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/drives/drive_master_test.cpp
      ${CMAKE_CURRENT_LIST_DIR}/firmware/drives/drive_faults_test.cpp
      ${CMAKE_CURRENT_LIST_DIR}/firmware/drives/drive_motion_test.cpp
      ${CMAKE_CURRENT_LIST_DIR}/firmware/drives/drive_plan_test.cpp
      ${CMAKE_CURRENT_LIST_DIR}/firmware/drives/sdo_transfer_test.cpp
    DEPS firmware_drives firmware_safety boards_sim_plant)
endif()
