# SPDX-License-Identifier: Apache-2.0
# Both ends of the link in one process, over mock carriers. Neither layer may hold it: it links host and firmware.
if(SC_HOST AND SC_SIM)
  add_executable(scribecell-link-bench ${CMAKE_CURRENT_LIST_DIR}/link/main.cpp ${CMAKE_CURRENT_LIST_DIR}/link/cell_end.cpp)
  set(root "${PROJECT_BINARY_DIR}/include/tests")
  file(MAKE_DIRECTORY "${root}")
  file(CREATE_LINK "${PROJECT_SOURCE_DIR}/tests" "${root}/tests" SYMBOLIC)
  target_include_directories(scribecell-link-bench PRIVATE "${root}")
  target_link_libraries(scribecell-link-bench PRIVATE sc_warnings sc_sanitizers boards_sim_carrier firmware_link
    host_bridge shared_link shared_path)
  set_target_properties(scribecell-link-bench PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
endif()
