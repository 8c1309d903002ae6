// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "shared/codes/codes.hpp"
#include "shared/link/blackbox.hpp"

namespace sc::host {

/// What a cell's black box holds, with the cell's time of each record, oldest first.
struct BlackBoxContent {
    struct Sample {
        double cell_s = 0.0;
        link::BlackboxSample at;
    };
    struct Event {
        double cell_s = 0.0;
        link::BlackboxEvent what;
    };
    bool frozen = false;
    Fault fault = Fault::none;  ///< that froze it
    std::uint8_t axis = 0xFF;
    double newest_s = 0.0;  ///< cell's time of the newest sample; frozen: of the fault
    std::vector<Sample> samples;
    std::vector<Event> events;
};

/// Takes up the content of one message: its head, and its records behind those that are there. Returns the number of
/// the record that is wanted next; that of the message's `end` when there are no more. Records of a message that claims
/// more than it can hold are dropped.
std::uint32_t take_chunk(const link::BlackboxChunk& chunk, BlackBoxContent& content);

}  // namespace sc::host
