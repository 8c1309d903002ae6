# SPDX-License-Identifier: Apache-2.0
sc_test(unit_trajectory LABEL unit TIMEOUT 120
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/trajectory/planner_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/trajectory/workloads_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/trajectory/parts_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/trajectory/arc_test.cpp
  DEPS firmware_trajectory)
