// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/link_url.hpp"

#include <gtest/gtest.h>

#include "host/bridge/open_transport.hpp"
#include "host/formats/error.hpp"

namespace sc::host {
namespace {

TEST(LinkUrl, TakesTheThreeForms) {
    EXPECT_TRUE(std::holds_alternative<SimulatedUrl>(parse_link_url("sim:")));
    EXPECT_TRUE(std::holds_alternative<SimulatedUrl>(parse_link_url("sim")));
    const auto serial = std::get<SerialUrl>(parse_link_url("serial:/dev/ttyUSB0?baud=921600"));
    EXPECT_EQ(serial.device, "/dev/ttyUSB0");
    EXPECT_EQ(serial.baud, 921600U);
    EXPECT_EQ(std::get<SerialUrl>(parse_link_url("serial:/dev/pts/3")).baud, 0U);
    const auto tcp = std::get<TcpUrl>(parse_link_url("tcp:127.0.0.1:7000"));
    EXPECT_EQ(tcp.host, "127.0.0.1");
    EXPECT_EQ(tcp.port, 7000);
    EXPECT_TRUE(is_simulated("sim:"));
    EXPECT_FALSE(is_simulated("tcp:localhost:1"));
}

TEST(LinkUrl, ASimulatedCellHasItsCarrier) {
    EXPECT_EQ(std::get<SimulatedUrl>(parse_link_url("sim:")).carrier, SimCarrier::serial);
    EXPECT_EQ(std::get<SimulatedUrl>(parse_link_url("sim:?carrier=serial")).carrier, SimCarrier::serial);
    EXPECT_EQ(std::get<SimulatedUrl>(parse_link_url("sim:?carrier=can")).carrier, SimCarrier::can);
    EXPECT_EQ(std::get<SimulatedUrl>(parse_link_url("sim:?carrier=canfd")).carrier, SimCarrier::canfd);
    EXPECT_TRUE(is_simulated("sim:?carrier=can"));
    const auto lasting = std::get<LockStepUrl>(parse_link_url("lockstep:/tmp/cell.socket?carrier=can"));
    EXPECT_EQ(lasting.path, "/tmp/cell.socket");
    EXPECT_EQ(lasting.carrier, SimCarrier::can);
    EXPECT_EQ(std::get<LockStepUrl>(parse_link_url("lockstep:x")).carrier, SimCarrier::serial);
}

TEST(LinkUrl, RefusesEverythingElse) {
    for (const char* url : {"",
                            "usb:1",
                            "sim:x",
                            "sim:?",
                            "sim:?carrier=",
                            "sim:?carrier=bus",
                            "sim:?baud=9",
                            "lockstep:?carrier=can",
                            "lockstep:x?carrier=y",
                            "serial",
                            "serial:",
                            "serial:?baud=9600",
                            "serial:/dev/x?speed=9",
                            "serial:/dev/x?baud=",
                            "serial:/dev/x?baud=9600x",
                            "serial:/dev/x?baud=-1",
                            "tcp:",
                            "tcp:7000",
                            "tcp::7000",
                            "tcp:host:",
                            "tcp:host:0",
                            "tcp:host:65536",
                            "tcp:host:7000x",
                            "/dev/ttyUSB0"}) {
        EXPECT_THROW(static_cast<void>(parse_link_url(url)), InputError) << url;
    }
}

TEST(LinkUrl, ACanBusIsClassicUnlessItSaysFd) {
    const auto classic = std::get<CanUrl>(parse_link_url("can:can0"));
    EXPECT_EQ(classic.interface, "can0");
    EXPECT_FALSE(classic.fd);
    EXPECT_FALSE(std::get<CanUrl>(parse_link_url("can:can1?fd=0")).fd);
    const auto fd = std::get<CanUrl>(parse_link_url("can:can1?fd=1"));
    EXPECT_EQ(fd.interface, "can1");
    EXPECT_TRUE(fd.fd);
    EXPECT_FALSE(is_simulated("can:can0"));
    EXPECT_EQ(line_bytes_per_s("can:can0", {}), 0U);
    for (const char* url :
         {"can:", "can:?fd=1", "can:can0?", "can:can0?fd=2", "can:can0?baud=9600", "can0", "canfd:can0"}) {
        EXPECT_THROW(static_cast<void>(parse_link_url(url)), InputError) << url;
    }
}

}  // namespace
}  // namespace sc::host
