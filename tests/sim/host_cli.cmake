# SPDX-License-Identifier: Apache-2.0
# These run the built programs as a person would.
if(SC_HOST AND SC_SIM)
  set(sc_cli_program ${CMAKE_CURRENT_LIST_DIR}/host/cli/program.cpp)
  sc_test(sim_bad_input_test LABEL sim TIMEOUT 120
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/bad_input_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  sc_test(sim_check_test LABEL sim TIMEOUT 120
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/check_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  sc_test(sim_scribe_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/scribe_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  sc_test(sim_preview_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/preview_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  sc_test(sim_source_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/source_test.cpp ${sc_cli_program}
    DEPS host_formats nlohmann_json::nlohmann_json)
  sc_test(sim_scribe_fault_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/scribe_fault_test.cpp ${sc_cli_program}
    DEPS host_formats nlohmann_json::nlohmann_json)
  sc_test(sim_resume_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/resume_test.cpp ${sc_cli_program}
    DEPS host_formats)
  sc_test(sim_surface_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/surface_test.cpp ${sc_cli_program}
    DEPS host_formats nlohmann_json::nlohmann_json)
  sc_test(sim_params_test LABEL sim TIMEOUT 120
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/params_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  sc_test(sim_pendant_test LABEL sim TIMEOUT 120
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/pendant_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  sc_test(sim_key_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/key_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  sc_test(sim_telemetry_command_test LABEL sim TIMEOUT 120
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/telemetry_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  sc_test(sim_replay_command_test LABEL sim TIMEOUT 120
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/replay_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  sc_test(sim_inspect_test LABEL sim TIMEOUT 180
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/inspect_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  sc_test(sim_axis_map_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/axis_map_test.cpp ${sc_cli_program}
    DEPS boards_sim_world nlohmann_json::nlohmann_json fmt::fmt)
  sc_test(sim_free_path_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/free_path_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  sc_test(sim_calibrate_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/calibrate_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  add_dependencies(sim_calibrate_test scribecell-plate-camera scribecell-field-truth)
  sc_test(sim_calibrate_cell_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/calibrate_cell_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  add_dependencies(sim_calibrate_cell_test scribecell scribecell-cell scribecell-survey scribecell-plate-camera)
  sc_test(sim_calibration_sets_test LABEL sim TIMEOUT 180
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/calibration_sets_test.cpp ${sc_cli_program}
    DEPS host_formats nlohmann_json::nlohmann_json)
  add_dependencies(sim_calibration_sets_test scribecell scribecell-cell)
  sc_test(sim_calibrate_places_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/calibrate_places_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  add_dependencies(sim_calibrate_places_test scribecell-rig scribecell-circles)
  sc_test(sim_chain_test LABEL sim TIMEOUT 120
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/chain_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  add_dependencies(sim_chain_test scribecell scribecell-rig)
  if(TARGET scribecell-hand-eye-peer)
    add_dependencies(sim_calibrate_places_test scribecell-hand-eye-peer)
  endif()
  sc_test(sim_cameras_test LABEL sim TIMEOUT 120
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/cameras_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  add_dependencies(sim_cameras_test scribecell scribecell-rig scribecell-circles)
  if(TARGET scribecell-stereo-peer)
    add_dependencies(sim_cameras_test scribecell-stereo-peer)
  endif()
  sc_test(sim_measure_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/measure_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  add_dependencies(sim_measure_test scribecell-station)
  sc_test(sim_markers_test LABEL sim TIMEOUT 120
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/markers_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  add_dependencies(sim_markers_test scribecell scribecell-circles)
  sc_test(sim_casting_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/casting_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  sc_test(sim_inspect_browser_test LABEL sim TIMEOUT 300
    SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/cli/inspect_browser_test.cpp ${sc_cli_program}
    DEPS nlohmann_json::nlohmann_json)
  add_dependencies(sim_casting_test scribecell-scanner)
  foreach(test sim_calibrate_places_test sim_casting_test sim_measure_test sim_inspect_test sim_inspect_browser_test sim_axis_map_test sim_free_path_test
      sim_bad_input_test sim_calibrate_test sim_check_test sim_scribe_test sim_preview_test sim_source_test
      sim_scribe_fault_test sim_key_test sim_params_test sim_surface_test sim_resume_test sim_replay_command_test sim_telemetry_command_test)
    add_dependencies(${test} scribecell scribecell-cell scribecell-replay)
  endforeach()
  if(NOT SC_SANITIZE)
    find_package(Python3 REQUIRED COMPONENTS Interpreter)
    foreach(workload a_dense b_corners c_mixed)
      add_test(NAME sim.motion_check_${workload} COMMAND Python3::Interpreter -B
        ${CMAKE_CURRENT_LIST_DIR}/host/cli/motion_check.py $<TARGET_FILE:scribecell-motion-bench> $<TARGET_FILE:scribecell>
        "${PROJECT_SOURCE_DIR}/tests/data/motion/${workload}.csv")
      set_tests_properties(sim.motion_check_${workload} PROPERTIES LABELS sim TIMEOUT 120)
    endforeach()
  endif()
endif()
