# SPDX-License-Identifier: Apache-2.0
sc_test(sim_controller LABEL sim TIMEOUT 300
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/controller_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/galvo_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/preview_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/beam_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/parameters_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/sensors_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/source_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/split_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/telemetry_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/cell_rig.cpp
  DEPS boards_sim firmware_controller shared_link shared_path shared_trace shared_hash firmware_recording)
sc_test(sim_follow LABEL sim TIMEOUT 300
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/follow_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/cell_rig.cpp
  DEPS boards_sim firmware_controller shared_link shared_path shared_trace shared_hash)
