# SPDX-License-Identifier: Apache-2.0
sc_test(property_motion LABEL property TIMEOUT 120
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/motion/planner_test.cpp
  DEPS firmware_motion)
