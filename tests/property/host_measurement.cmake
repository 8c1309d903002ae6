# SPDX-License-Identifier: Apache-2.0
find_package(rapidcheck REQUIRED)
sc_test(property_host_measurement LABEL property TIMEOUT 120
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/measurement/station_test.cpp
  DEPS host_measurement rapidcheck)
