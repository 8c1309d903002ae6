# SPDX-License-Identifier: Apache-2.0
sc_test(sim_firmware_sensors LABEL sim
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/sensors/hub_test.cpp
  DEPS boards_sim_sensors boards_sim_world firmware_sensors)
