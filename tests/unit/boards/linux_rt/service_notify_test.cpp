// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/service_notify.hpp"

#include <array>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace sc::linux_rt {
namespace {

class ServiceNotifyTest : public testing::Test {
protected:
    void TearDown() override {
        for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) {
            ::unsetenv(name);
        }
    }
};

TEST_F(ServiceNotifyTest, SendsDatagramsToTheManagersSocketOfEitherKind) {
    for (const bool abstract : {false, true}) {
        const std::string path = (abstract ? "@sc-notify-" : "/tmp/sc-notify-") + std::to_string(::getpid());
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.copy(static_cast<char*>(address.sun_path), path.size());
        if (abstract) {
            address.sun_path[0] = '\0';
        }
        const int manager = ::socket(AF_UNIX, SOCK_DGRAM, 0);
        const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
        ASSERT_EQ(::bind(manager, reinterpret_cast<const sockaddr*>(&address), size), 0);
        ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
        const ServiceNotify notify;
        EXPECT_TRUE(notify.say("READY=1"));
        std::array<char, 32> got{};
        const ssize_t n = ::recv(manager, got.data(), got.size(), MSG_DONTWAIT);
        ASSERT_EQ(n, 7);
        EXPECT_EQ(std::string(got.data(), 7), "READY=1");
        ::close(manager);
        ::unlink(path.c_str());
        EXPECT_FALSE(notify.say("WATCHDOG=1"));
    }
}

TEST_F(ServiceNotifyTest, WithoutAManagerNothingIsSent) {
    ::unsetenv("NOTIFY_SOCKET");
    const ServiceNotify notify;
    EXPECT_FALSE(notify.say("READY=1"));
    EXPECT_FALSE(notify.watchdog_ns());
}

TEST_F(ServiceNotifyTest, TheWatchdogIsThisProcessesOwn) {
    ::setenv("WATCHDOG_USEC", "500000", 1);
    EXPECT_EQ(ServiceNotify().watchdog_ns(), 250'000'000);
    ::setenv("WATCHDOG_PID", std::to_string(::getpid()).c_str(), 1);
    EXPECT_EQ(ServiceNotify().watchdog_ns(), 250'000'000);
    ::setenv("WATCHDOG_PID", "1", 1);
    EXPECT_FALSE(ServiceNotify().watchdog_ns());
    ::unsetenv("WATCHDOG_PID");
    ::setenv("WATCHDOG_USEC", "5x", 1);
    EXPECT_FALSE(ServiceNotify().watchdog_ns());
}

}  // namespace
}  // namespace sc::linux_rt
