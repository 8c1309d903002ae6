# SPDX-License-Identifier: Apache-2.0
sc_test(recording_unit LABEL unit
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/firmware/recording/io_image_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/recording/log_test.cpp
  DEPS firmware_recording shared_hash shared_link)
