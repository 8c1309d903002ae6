# SPDX-License-Identifier: Apache-2.0
sc_test(sim_replay LABEL sim TIMEOUT 120
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/boards/replay/replay_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/cell_rig.cpp
  DEPS boards_sim boards_replay firmware_recording shared_link shared_path shared_trace shared_hash
       nlohmann_json::nlohmann_json)
