# SPDX-License-Identifier: Apache-2.0
sc_test(host_path_parts_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/path/check_test.cpp ${CMAKE_CURRENT_LIST_DIR}/host/path/line_width_test.cpp ${CMAKE_CURRENT_LIST_DIR}/host/path/plane_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/path/profile_test.cpp ${CMAKE_CURRENT_LIST_DIR}/host/path/route_test.cpp
  DEPS host_path)
sc_test(host_path_job_plan_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/path/face_places_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/path/job_plan_test.cpp ${CMAKE_CURRENT_LIST_DIR}/host/path/look_plan_test.cpp ${CMAKE_CURRENT_LIST_DIR}/host/path/free_path_test.cpp ${CMAKE_CURRENT_LIST_DIR}/host/path/job_refusal_test.cpp
  DEPS host_path)
sc_test(host_path_line_job_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/path/line_job_test.cpp
  DEPS host_path)
sc_test(host_path_split_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/path/split_path_test.cpp
  DEPS host_path)
