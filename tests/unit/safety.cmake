# SPDX-License-Identifier: Apache-2.0
sc_test(unit_firmware_safety LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/safety/frame_guard_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/safety/laser_rule_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/safety/shutter_watch_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/safety/supervisor_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/safety/watch_test.cpp
  DEPS firmware_safety)
