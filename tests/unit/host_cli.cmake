# SPDX-License-Identifier: Apache-2.0
sc_test(host_cli_test LABEL unit
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/host/cli/asked_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/cli/text_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/cli/triple_head_test.cpp
  DEPS host_cli)
