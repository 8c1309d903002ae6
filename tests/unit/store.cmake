# SPDX-License-Identifier: Apache-2.0
sc_test(unit_firmware_store LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/store/parameter_store_test.cpp
  DEPS firmware_store)
