# SPDX-License-Identifier: Apache-2.0
# The host's client and the controller's endpoint, over mock carriers in one virtual time.
if(SC_HOST AND SC_SIM)
  sc_test(sim_sealed_link LABEL sim TIMEOUT 120
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/link/sealed_test.cpp ${PROJECT_SOURCE_DIR}/tests/bench/link/cell_end.cpp
    DEPS boards_sim_carrier firmware_link host_bridge shared_link shared_path)
endif()
