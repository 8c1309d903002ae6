# SPDX-License-Identifier: Apache-2.0
sc_test(unit_boards_socketcan LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/boards/socketcan/can_socket_test.cpp
  DEPS boards_socketcan)
