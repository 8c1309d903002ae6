# SPDX-License-Identifier: Apache-2.0
sc_test(property_firmware_sensors LABEL property
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/sensors/noise_test.cpp
  DEPS boards_sim_sensors boards_sim_world firmware_sensors shared_machine)
