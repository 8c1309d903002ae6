# SPDX-License-Identifier: Apache-2.0
sc_test(host_drives_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/formats/eds_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/drives/drive_plan_file_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/drives/drive_report_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/drives/emergency_text_test.cpp
  DEPS boards_drive_file host_drives host_formats firmware_drives)
