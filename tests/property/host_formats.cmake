# SPDX-License-Identifier: Apache-2.0
sc_test(host_formats_mutation_test LABEL property
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/formats/mutation_test.cpp
  DEPS host_formats)
