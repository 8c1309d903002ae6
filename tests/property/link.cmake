# SPDX-License-Identifier: Apache-2.0
sc_test(property_shared_path LABEL property
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/shared/path/block_test.cpp
  DEPS shared_path)
sc_test(property_shared_link LABEL property
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/shared/link/can_framing_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/link/codec_test.cpp
  DEPS shared_link)
sc_test(property_firmware_link LABEL property
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/link/endpoint_test.cpp
  DEPS firmware_link shared_link)
