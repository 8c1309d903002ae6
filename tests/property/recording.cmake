# SPDX-License-Identifier: Apache-2.0
sc_test(property_firmware_recording LABEL property
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/recording/log_test.cpp
  DEPS firmware_recording shared_hash shared_link)
