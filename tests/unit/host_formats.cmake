# SPDX-License-Identifier: Apache-2.0
set(dir ${CMAKE_CURRENT_LIST_DIR}/host/formats)
sc_test(host_formats_tables_test LABEL unit
  SOURCES ${dir}/csv_test.cpp ${dir}/error_test.cpp ${dir}/file_test.cpp ${dir}/lag_plate_test.cpp ${dir}/plate_test.cpp ${dir}/poses_test.cpp ${dir}/table_test.cpp ${dir}/text_test.cpp
    ${dir}/unit_guess_test.cpp
  DEPS host_formats)
sc_test(host_formats_toml_test LABEL unit
  SOURCES ${dir}/calibration_set_test.cpp ${dir}/calibration_store_test.cpp ${dir}/cameras_test.cpp ${dir}/job_test.cpp ${dir}/part_test.cpp ${dir}/recipe_test.cpp
    ${dir}/scan_set_test.cpp ${dir}/target_test.cpp
  DEPS host_formats)
sc_test(host_formats_binary_test LABEL unit
  SOURCES ${dir}/job_items_test.cpp ${dir}/journal_test.cpp ${dir}/pulse_trace_test.cpp
  DEPS host_formats SQLite::SQLite3)
sc_test(host_calibration_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/calibration/galvo_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/calibration/hand_eye_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/calibration/lag_fit_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/calibration/marker_check_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/calibration/rigid_fit_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/calibration/transforms_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/calibration/turntable_fit_test.cpp
  DEPS host_calibration)
sc_test(host_calibration_cell_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/calibration/focus_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/calibration/plate_fit_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/calibration/sensor_ray_test.cpp
  DEPS host_calibration Eigen3::Eigen)
sc_test(host_calibration_cameras_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/calibration/camera_fit_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/calibration/marker_identity_test.cpp
  DEPS host_calibration)
sc_test(host_formats_geometry_test LABEL unit
  SOURCES ${dir}/mesh_test.cpp ${dir}/scan_test.cpp
  DEPS host_formats)
sc_test(host_calibration_sets_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/calibration/drift_check_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/calibration/hand_eye_suggest_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/calibration/scribe_budget_test.cpp
  DEPS host_calibration)
