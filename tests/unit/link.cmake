# SPDX-License-Identifier: Apache-2.0
sc_test(unit_shared_hash LABEL unit
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/shared/hash/crc_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/hash/fnv_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/hash/sha256_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/wire/bytes_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/trace/trace_test.cpp
  DEPS shared_hash shared_wire shared_trace)
sc_test(unit_shared_crypto LABEL unit SOURCES ${CMAKE_CURRENT_LIST_DIR}/shared/crypto/cmac_test.cpp DEPS shared_crypto)
sc_test(unit_shared_path LABEL unit
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/shared/path/block_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/path/item_queue_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/path/job_hash_test.cpp
  DEPS shared_path shared_hash)
sc_test(unit_shared_link LABEL unit
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/shared/link/can_framing_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/link/cobs_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/link/codec_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/link/config_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/link/counter_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/shared/link/docs_test.cpp
  DEPS shared_link)
sc_test(unit_firmware_link LABEL unit
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/firmware/link/endpoint_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/link/job_stream_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/link/telemetry_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/link/reply_memory_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/firmware/link/seal_test.cpp
  DEPS firmware_link shared_link)
include(${CMAKE_CURRENT_LIST_DIR}/firmware/link/seal_mutants.cmake)
sc_test(unit_sim_carrier LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/boards/sim/carrier/carrier_test.cpp
  DEPS boards_sim_carrier shared_link)
