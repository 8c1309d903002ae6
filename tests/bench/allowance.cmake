# SPDX-License-Identifier: Apache-2.0
# The distance engine beside its peers. Peers are of the tier bench and take part where they are installed; CGAL is GPL, so
# this program is a test and never ships.
if(SC_HOST)
  find_package(nlohmann_json REQUIRED)
  add_executable(scribecell-allowance-bench ${CMAKE_CURRENT_LIST_DIR}/allowance_bench.cpp
    ${CMAKE_CURRENT_LIST_DIR}/allowance_workload.cpp ${CMAKE_CURRENT_LIST_DIR}/peer_embree.cpp
    ${CMAKE_CURRENT_LIST_DIR}/peer_cgal.cpp)
  set(root "${PROJECT_BINARY_DIR}/include/tests")
  file(MAKE_DIRECTORY "${root}")
  file(CREATE_LINK "${PROJECT_SOURCE_DIR}/tests" "${root}/tests" SYMBOLIC)
  target_include_directories(scribecell-allowance-bench PRIVATE "${root}")
  target_link_libraries(scribecell-allowance-bench PRIVATE sc_warnings sc_sanitizers host_inspection host_formats
    nlohmann_json::nlohmann_json)
  set_target_properties(scribecell-allowance-bench PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
  find_path(SC_EMBREE_INCLUDE embree3/rtcore.h)
  find_library(SC_EMBREE_LIBRARY embree3)
  if(SC_EMBREE_INCLUDE AND SC_EMBREE_LIBRARY)
    target_compile_definitions(scribecell-allowance-bench PRIVATE SC_WITH_EMBREE)
    target_link_libraries(scribecell-allowance-bench PRIVATE ${SC_EMBREE_LIBRARY})
  endif()
  find_path(SC_CGAL_INCLUDE CGAL/Side_of_triangle_mesh.h)
  find_library(SC_GMP_LIBRARY gmp)
  find_library(SC_MPFR_LIBRARY mpfr)
  # Debian 12's CGAL does not compile with Clang 19.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND SC_CGAL_INCLUDE AND SC_GMP_LIBRARY AND SC_MPFR_LIBRARY)
    # Its headers are not written for our warnings.
    set_source_files_properties(${CMAKE_CURRENT_LIST_DIR}/peer_cgal.cpp PROPERTIES
      COMPILE_DEFINITIONS SC_WITH_CGAL COMPILE_OPTIONS "-w;-frounding-math")
    target_link_libraries(scribecell-allowance-bench PRIVATE ${SC_GMP_LIBRARY} ${SC_MPFR_LIBRARY})
  endif()
endif()
