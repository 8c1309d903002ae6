# SPDX-License-Identifier: Apache-2.0
sc_test(property_trajectory LABEL property TIMEOUT 300
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/trajectory/planner_test.cpp
  DEPS firmware_trajectory)
