# SPDX-License-Identifier: Apache-2.0
# A number over all sources that the image is made of. Image and PC side are different builds; the number tells whether
# both were made of the same sources.
if(CMAKE_SCRIPT_MODE_FILE)
  # cmake -DROOT=... -DLIST=... -DOUT=... -P build_id.cmake
  file(STRINGS "${LIST}" sources)
  set(digests "")
  foreach(source IN LISTS sources)
    file(SHA256 "${ROOT}/${source}" digest)
    string(APPEND digests "${source} ${digest}\n")
  endforeach()
  string(SHA256 digest "${digests}")
  string(SUBSTRING "${digest}" 0 16 digest)
  string(CONCAT text "// SPDX-License-Identifier: Apache-2.0\n#pragma once\n\n#include <cstdint>\n\n"
    "namespace sc::mps2_an500 {\n\ninline constexpr std::uint64_t kBuildId = 0x${digest}ULL;\n\n}\n")
  file(CONFIGURE OUTPUT "${OUT}" CONTENT "${text}")
  return()
endif()

set(SC_BUILD_ID_SCRIPT "${CMAKE_CURRENT_LIST_FILE}")
file(GLOB_RECURSE sc_build_id_sources RELATIVE "${PROJECT_SOURCE_DIR}" CONFIGURE_DEPENDS
  "${PROJECT_SOURCE_DIR}/shared/*.?pp" "${PROJECT_SOURCE_DIR}/firmware/*.?pp"
  "${PROJECT_SOURCE_DIR}/boards/mps2_an500/image/*.*" "${PROJECT_SOURCE_DIR}/boards/mps2_an500/*.hpp")
list(SORT sc_build_id_sources)
set(SC_BUILD_ID_ROOT "${PROJECT_BINARY_DIR}/mps2_an500")
set(sc_build_id_list "${SC_BUILD_ID_ROOT}/sources.txt")
set(SC_BUILD_ID_HEADER "${SC_BUILD_ID_ROOT}/boards/mps2_an500/build_id.hpp")
list(JOIN sc_build_id_sources "\n" sc_build_id_text)
file(CONFIGURE OUTPUT "${sc_build_id_list}" CONTENT "${sc_build_id_text}\n")
list(TRANSFORM sc_build_id_sources PREPEND "${PROJECT_SOURCE_DIR}/" OUTPUT_VARIABLE sc_build_id_paths)
add_custom_command(OUTPUT "${SC_BUILD_ID_HEADER}"
  COMMAND "${CMAKE_COMMAND}" -DROOT=${PROJECT_SOURCE_DIR} -DLIST=${sc_build_id_list} -DOUT=${SC_BUILD_ID_HEADER}
    -P "${SC_BUILD_ID_SCRIPT}"
  DEPENDS ${sc_build_id_paths} "${sc_build_id_list}" "${SC_BUILD_ID_SCRIPT}" VERBATIM)
add_custom_target(mps2_an500_build_id DEPENDS "${SC_BUILD_ID_HEADER}")

# Gives the sources of a target "boards/mps2_an500/build_id.hpp".
function(sc_use_build_id target)
  target_include_directories(${target} PRIVATE "${SC_BUILD_ID_ROOT}")
  add_dependencies(${target} mps2_an500_build_id)
endfunction()

# Builds that are only configured (clang-tidy reads their commands) need a header to look at.
if(NOT EXISTS "${SC_BUILD_ID_HEADER}")
  execute_process(COMMAND "${CMAKE_COMMAND}" -DROOT=${PROJECT_SOURCE_DIR} -DLIST=${sc_build_id_list}
    -DOUT=${SC_BUILD_ID_HEADER} -P "${SC_BUILD_ID_SCRIPT}" COMMAND_ERROR_IS_FATAL ANY)
endif()
