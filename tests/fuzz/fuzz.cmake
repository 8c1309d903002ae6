# SPDX-License-Identifier: Apache-2.0
# libFuzzer on every decoder and reader of files, in the build with the sanitizers: the kept inputs of each target are run
# again, then a bounded number of new ones from a fixed seed. ./run fuzz runs longer.
if(NOT SC_FUZZ OR NOT SC_HOST)
  return()
endif()
set(root "${PROJECT_BINARY_DIR}/include/tests")
file(MAKE_DIRECTORY "${root}")
file(CREATE_LINK "${PROJECT_SOURCE_DIR}/tests" "${root}/tests" SYMBOLIC)
add_executable(scribecell-fuzz ${CMAKE_CURRENT_LIST_DIR}/main.cpp ${CMAKE_CURRENT_LIST_DIR}/wire_targets.cpp
  ${CMAKE_CURRENT_LIST_DIR}/file_targets.cpp)
target_include_directories(scribecell-fuzz PRIVATE "${root}")
target_link_libraries(scribecell-fuzz PRIVATE sc_warnings sc_sanitizers host_bridge host_formats host_pendant firmware_drives firmware_laser
  firmware_link firmware_recording firmware_sensors shared_link shared_trace)
target_compile_options(scribecell-fuzz PRIVATE -fsanitize=fuzzer-no-link)
target_link_options(scribecell-fuzz PRIVATE -fsanitize=fuzzer)
set_target_properties(scribecell-fuzz PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")

set(wire_targets endpoint serial host_wire can block machine_config axis_map recording trace sensors drive mopa pendant)
set(file_targets job calibration recipe part blank_model scan_set target stand eds station_job stations known points route table
  plate_plan measured_crosses lag_plan lag_marks journal pulse_trace sample_header mesh_stl mesh_obj scan_ply scan_pcd scan_xyz
  pendant_script)
foreach(target IN LISTS wire_targets file_targets)
  set(runs 3000)
  if(target IN_LIST file_targets)
    set(runs 1000)
  endif()
  add_test(NAME fuzz.${target} COMMAND scribecell-fuzz -seed=1 -runs=${runs} -max_len=4096 -timeout=10 -rss_limit_mb=2048
    -artifact_prefix=${PROJECT_BINARY_DIR}/fuzz-${target}- -print_final_stats=0 -verbosity=0
    "${PROJECT_BINARY_DIR}/fuzz/${target}" "${PROJECT_SOURCE_DIR}/tests/fuzz/corpus/${target}")
  # The first folder takes what is new; it is not kept from run to run by the tests.
  file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/fuzz/${target}")
  set_tests_properties(fuzz.${target} PROPERTIES LABELS fuzz TIMEOUT 300 ENVIRONMENT "SC_FUZZ_TARGET=${target}")
endforeach()
