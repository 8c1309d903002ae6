# SPDX-License-Identifier: Apache-2.0
sc_test(property_trajectory LABEL property TIMEOUT 300
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/trajectory/planner_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/trajectory/arc_test.cpp
  DEPS firmware_trajectory)
if(TARGET property_trajectory)
  # All of them where they are quick; the other builds look for what differs there, not for rare paths.
  set(paths 250)
  if(SC_SANITIZE OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set(paths 25)
  endif()
  target_compile_definitions(property_trajectory PRIVATE SC_RANDOM_PATHS=${paths})
endif()
