# SPDX-License-Identifier: Apache-2.0
sc_test(host_pendant_test LABEL unit
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/host/pendant/control_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/pendant/script_port_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/pendant/whb04b_test.cpp
  DEPS host_pendant)
