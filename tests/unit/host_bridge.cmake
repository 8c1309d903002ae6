# SPDX-License-Identifier: Apache-2.0
sc_test(host_bridge_test LABEL unit
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/client_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/client_telemetry_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/clock_fit_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/fake_cell.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/fd_transport_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/link_url_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/key_file_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/machine_parameters_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/ports_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/progress_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/resume_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/session_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/sim_transport_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/socket_can_transport_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/bridge/streamer_test.cpp
  DEPS host_bridge)
