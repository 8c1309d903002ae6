# SPDX-License-Identifier: Apache-2.0
if(SC_SIM)
  sc_test(sim_boards_drive_check LABEL sim TIMEOUT 120
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/boards/drive_check_test.cpp
    DEPS boards_drive_check boards_drive_process boards_sim_plant)
endif()
