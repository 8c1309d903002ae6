// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/sim_transport.hpp"

#include <array>
#include <functional>
#include <thread>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include "host/bridge/unique_fd.hpp"

namespace sc::host {
namespace {

constexpr std::int64_t kMs = 1'000'000;

struct Request {
    std::int64_t run_until = 0;
    std::vector<std::uint8_t> bytes;
};
struct Answer {
    std::int64_t now = 0;
    std::vector<std::uint8_t> bytes;
};

bool read_all(int fd, void* to, std::size_t size) {
    return ::recv(fd, to, size, MSG_WAITALL) == static_cast<ssize_t>(size);
}

/// The other side of the conversation, written from its description alone.
class Peer {
public:
    using Behaviour = std::function<Answer(const Request&, std::int64_t now)>;
    explicit Peer(Behaviour behaviour) : behaviour_(std::move(behaviour)) {
        std::array<int, 2> pair{};
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, pair.data()), 0);
        host_.reset(pair[0]);
        cell_.reset(pair[1]);
        thread_ = std::thread([this] { serve(); });
    }
    Peer(const Peer&) = delete;
    Peer& operator=(const Peer&) = delete;
    ~Peer() { stop(); }
    void stop() {
        host_.reset();
        if (thread_.joinable()) {
            thread_.join();
        }
    }
    [[nodiscard]] int socket() const { return host_.get(); }
    std::vector<Request> requests;  ///< read after stop()
    std::vector<std::int64_t> began;

private:
    void serve() {
        std::int64_t now = 0;
        for (;;) {
            std::uint32_t size = 0;
            Request request;
            if (!read_all(cell_.get(), &size, 4) || !read_all(cell_.get(), &request.run_until, 8)) {
                break;
            }
            request.bytes.resize(size - 8);
            if (!request.bytes.empty() && !read_all(cell_.get(), request.bytes.data(), request.bytes.size())) {
                break;
            }
            requests.push_back(request);
            began.push_back(now);
            const Answer answer = behaviour_(request, now);
            if (answer.now < 0) {
                break;
            }
            now = answer.now;
            const auto answer_size = static_cast<std::uint32_t>(8 + answer.bytes.size());
            ::send(cell_.get(), &answer_size, 4, MSG_NOSIGNAL);
            ::send(cell_.get(), &answer.now, 8, MSG_NOSIGNAL);
            ::send(cell_.get(), answer.bytes.data(), answer.bytes.size(), MSG_NOSIGNAL);
        }
        cell_.reset();
    }
    Behaviour behaviour_;
    UniqueFd host_;
    UniqueFd cell_;
    std::thread thread_;
};

/// Runs whole ticks of 1 ms and echoes.
Answer echo(const Request& request, std::int64_t now) {
    return {std::max(now, request.run_until / kMs * kMs), request.bytes};
}

HostTime at(std::int64_t ns) { return HostTime(Nanoseconds(ns)); }

TEST(LockStepTransport, TimeIsTheCellsAndPassesOnlyInReceive) {
    Peer peer(echo);
    LockStepTransport link(peer.socket(), {});
    std::array<std::uint8_t, 16> bytes{};
    EXPECT_EQ(link.now(), at(0));
    EXPECT_EQ(link.receive(bytes, at(20 * kMs)), 0U);
    EXPECT_EQ(link.now(), at(20 * kMs));
    const std::vector<std::uint8_t> word{1, 2, 3};
    link.send(word);
    EXPECT_EQ(link.now(), at(20 * kMs));
    ASSERT_EQ(link.receive(bytes, at(90 * kMs)), 3U);
    EXPECT_EQ(std::vector<std::uint8_t>(bytes.begin(), bytes.begin() + 3), word);
    EXPECT_LT(link.now(), at(90 * kMs));
}

TEST(LockStepTransport, HandsOutWhatDidNotFitBeforeTimeGoesOn) {
    Peer peer(echo);
    LockStepTransport link(peer.socket(), {});
    link.send(std::vector<std::uint8_t>(10, 7));
    std::array<std::uint8_t, 4> bytes{};
    ASSERT_EQ(link.receive(bytes, at(50 * kMs)), 4U);
    const HostTime then = link.now();
    EXPECT_EQ(link.receive(bytes, at(50 * kMs)), 4U);
    EXPECT_EQ(link.receive(bytes, at(50 * kMs)), 2U);
    EXPECT_EQ(link.now(), then);
}

TEST(LockStepTransport, PartsOfATickStillMakeTimePass) {
    Peer peer(echo);
    LockStepTransport link(peer.socket(), {});
    std::array<std::uint8_t, 4> bytes{};
    EXPECT_EQ(link.receive(bytes, at(300'000)), 0U);
    EXPECT_GE(link.now(), at(300'000));
    EXPECT_LE(link.now(), at(2 * kMs));
    EXPECT_FALSE(link.closed());
}

TEST(LockStepTransport, ClosesWhenTheCellEndsStandsStillOrGoesBack) {
    const auto ends = [](const Request&, std::int64_t) { return Answer{-1, {}}; };
    const auto stands = [](const Request&, std::int64_t now) { return Answer{now, {}}; };
    const auto back = [](const Request&, std::int64_t now) { return Answer{now > 0 ? now - 1 : 5, {}}; };
    for (const Peer::Behaviour& behaviour : {Peer::Behaviour(ends), Peer::Behaviour(stands), Peer::Behaviour(back)}) {
        Peer peer(behaviour);
        LockStepTransport link(peer.socket(), {});
        std::array<std::uint8_t, 4> bytes{};
        EXPECT_EQ(link.receive(bytes, at(50 * kMs)), 0U);
        EXPECT_TRUE(link.closed());
        link.send(bytes);
        EXPECT_EQ(link.receive(bytes, at(90 * kMs)), 0U);
    }
}

/// When each numbered chunk reached the cell.
std::vector<std::int64_t> arrivals(Nanoseconds jitter, std::uint64_t seed, std::vector<std::uint8_t>& order) {
    Peer peer([](const Request& r, std::int64_t now) { return Answer{std::max(now, r.run_until), {}}; });
    LockStepTransport link(peer.socket(), {.jitter = jitter, .seed = seed});
    std::array<std::uint8_t, 4> bytes{};
    for (std::uint8_t i = 0; i < 100; ++i) {
        link.send(std::array<std::uint8_t, 1>{i});
        static_cast<void>(link.receive(bytes, link.now() + Nanoseconds(kMs)));
    }
    static_cast<void>(link.receive(bytes, link.now() + Nanoseconds(100 * kMs)));
    peer.stop();
    std::vector<std::int64_t> when;
    for (std::size_t i = 0; i < peer.requests.size(); ++i) {
        for (const std::uint8_t byte : peer.requests[i].bytes) {
            when.push_back(peer.began[i]);
            order.push_back(byte);
        }
    }
    return when;
}

TEST(LockStepTransport, JitterDelaysEachChunkWithinItsBoundAndKeepsTheOrder) {
    std::vector<std::uint8_t> order;
    const auto when = arrivals(Nanoseconds(7 * kMs), 3, order);
    ASSERT_EQ(when.size(), 100U);
    int late = 0;
    for (std::size_t i = 0; i < when.size(); ++i) {
        EXPECT_EQ(order[i], i);
        const std::int64_t delay = when[i] - static_cast<std::int64_t>(i) * kMs;
        EXPECT_GE(delay, 0);
        EXPECT_LE(delay, 7 * kMs);
        late += delay > kMs ? 1 : 0;
    }
    EXPECT_GT(late, 50);
}

TEST(LockStepTransport, JitterFollowsTheSeedAndNothingElse) {
    std::vector<std::uint8_t> order;
    const auto first = arrivals(Nanoseconds(7 * kMs), 3, order);
    EXPECT_EQ(arrivals(Nanoseconds(7 * kMs), 3, order), first);
    EXPECT_NE(arrivals(Nanoseconds(7 * kMs), 4, order), first);
    const auto none = arrivals(Nanoseconds(0), 3, order);
    for (std::size_t i = 0; i < none.size(); ++i) {
        EXPECT_EQ(none[i], static_cast<std::int64_t>(i) * kMs);
    }
}

}  // namespace
}  // namespace sc::host
