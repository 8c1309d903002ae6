# SPDX-License-Identifier: Apache-2.0
sc_test(host_protocol_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/protocol/protocol_files_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/protocol/capture_test.cpp
  DEPS host_protocol host_formats shared_link nlohmann_json::nlohmann_json)
