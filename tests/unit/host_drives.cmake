# SPDX-License-Identifier: Apache-2.0
sc_test(host_drives_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/formats/eds_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/drives/drive_report_test.cpp
  DEPS host_drives host_formats firmware_drives)
