// SPDX-License-Identifier: Apache-2.0
// The line between a host and the controller: what goes in at one end comes out at the other, and at what time.
#include "boards/sim/link_line.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "shared/link/can_port.hpp"
#include "shared/link/can_record.hpp"
#include "shared/link/serial.hpp"

namespace {

using namespace sc;  // NOLINT(google-build-using-namespace): a test

constexpr std::int64_t kTickNs = 1'000'000;
using Bytes = std::vector<std::uint8_t>;

Bytes message(std::uint16_t counter) {
    link::ConfigChunk chunk;
    chunk.offset = counter;
    chunk.data.size = 200;
    for (std::size_t i = 0; i < chunk.data.size; ++i) {
        chunk.data.data.at(i) = static_cast<std::uint8_t>(i * 7);
    }
    std::array<std::uint8_t, link::kSerialCapacity> bytes{};
    const std::size_t size = link::encode_serial(chunk, counter, bytes);
    return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)};
}

/// What a host hands over or gets: frames as records, of whole messages.
Bytes records(link::CanPort<4096>& port, const Bytes& bytes, bool fd) {
    EXPECT_EQ(port.push(bytes), bytes.size());
    Bytes out;
    link::LinkCanFrame frame;
    while (port.next(frame)) {
        out.resize(out.size() + link::can_record_size(fd));
        link::put_can_record(frame, std::span(out).last(link::can_record_size(fd)));
    }
    return out;
}

Bytes from_records(link::CanPort<4096>& port, const Bytes& bytes, bool fd) {
    Bytes out;
    const std::size_t size = link::can_record_size(fd);
    for (std::size_t at = 0; at + size <= bytes.size(); at += size) {
        const auto frame = link::get_can_record(std::span(bytes).subspan(at, size), fd);
        std::array<std::uint8_t, link::kSerialCapacity> whole{};
        const std::size_t n = frame ? port.take(*frame, whole) : 0;
        out.insert(out.end(), whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n));
    }
    return out;
}

class LinkLineOverCan : public testing::TestWithParam<bool> {};

TEST_P(LinkLineOverCan, CarriesMessagesBothWaysAtTheRateOfTheBus) {
    const bool fd = GetParam();
    const auto line = sim::make_link_line(fd ? sim::LinkCarrier::canfd : sim::LinkCarrier::can, 9600, kTickNs);
    link::CanPort<4096> host(link::kCanIdToController, fd);
    Bytes to_controller;
    Bytes frames;
    const Bytes frames_in = records(host, message(1), fd);
    // The host's records may come in any portions.
    line->push_host(std::span(frames_in).first(5));
    line->push_host(std::span(frames_in).subspan(5));
    line->push_controller(message(2));
    int ticks = 0;
    Bytes to_host;
    while ((to_controller.empty() || to_host.empty()) && ticks < 50) {
        line->tick(to_controller, frames);
        ++ticks;
        const Bytes whole = from_records(host, frames, fd);
        to_host.insert(to_host.end(), whole.begin(), whole.end());
        frames.clear();
    }
    EXPECT_EQ(to_controller, message(1));
    EXPECT_EQ(to_host, message(2));
    // Two messages of 210 bytes: some 60 frames of 0.12 ms, or 8 of 0.15 ms.
    EXPECT_GE(ticks, fd ? 1 : 6);
    EXPECT_LE(ticks, fd ? 2 : 9);
}

TEST_P(LinkLineOverCan, WhileItIsCutAllIsLostAndThenItGoesOn) {
    const bool fd = GetParam();
    const auto line = sim::make_link_line(fd ? sim::LinkCarrier::canfd : sim::LinkCarrier::can, 9600, kTickNs);
    link::CanPort<4096> host(link::kCanIdToController, fd);
    Bytes to_controller;
    Bytes to_host;
    line->push_host(records(host, message(1), fd));
    line->push_controller(message(2));
    line->set_connected(false);
    line->push_host(records(host, message(3), fd));
    line->push_controller(message(4));
    for (int i = 0; i < 20; ++i) {
        line->tick(to_controller, to_host);
    }
    EXPECT_TRUE(to_controller.empty());
    EXPECT_TRUE(to_host.empty());
    line->set_connected(true);
    line->push_host(records(host, message(5), fd));
    line->push_controller(message(6));
    for (int i = 0; i < 20; ++i) {
        line->tick(to_controller, to_host);
    }
    EXPECT_EQ(to_controller, message(5));
    EXPECT_EQ(from_records(host, to_host, fd), message(6));
}

INSTANTIATE_TEST_SUITE_P(Kinds, LinkLineOverCan, testing::Bool());

TEST(LinkLine, ASerialOneKeepsItsRate) {
    const auto line = sim::make_link_line(sim::LinkCarrier::serial, 100'000, kTickNs);
    const Bytes bytes(25, 0x55);
    line->push_host(bytes);
    Bytes to_controller;
    Bytes to_host;
    line->tick(to_controller, to_host);
    EXPECT_EQ(to_controller.size(), 10U);
    line->tick(to_controller, to_host);
    line->tick(to_controller, to_host);
    EXPECT_EQ(to_controller, bytes);
    EXPECT_TRUE(to_host.empty());
}

}  // namespace
