// SPDX-License-Identifier: Apache-2.0
// Sealed jobs over mock carriers: with everything that may go wrong, and with somebody else on the bus.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/bridge/client.hpp"
#include "host/bridge/resume.hpp"
#include "host/bridge/session.hpp"
#include "shared/link/blocks.hpp"
#include "shared/link/seal.hpp"
#include "shared/path/job_hash.hpp"
#include "tests/bench/link/link_world.hpp"

namespace {

using namespace sc;         // NOLINT(google-build-using-namespace): what is under test
using namespace sc::bench;  // NOLINT(google-build-using-namespace): its world

constexpr crypto::Key kKey{9, 8, 7, 6, 5, 4, 3, 2, 1, 0, 1, 2, 3, 4, 5, 6};
constexpr std::int64_t kMs = 1'000'000;

std::vector<Item> job_of(std::uint32_t points) {
    std::vector<Item> items{Turn{0},
                            PathBegin{.path = 1, .speed_um_s = 20'000, .pitch_nm = 20'000, .energy_nj = 500'000}};
    for (std::uint32_t k = 0; k < points; ++k) {
        items.emplace_back(PathPoint{static_cast<std::int32_t>(k), static_cast<std::int32_t>(k % 7), 1});
    }
    items.emplace_back(PathEnd{});
    items.emplace_back(JobEnd{});
    return items;
}

link::EndpointOptions endpoint_options() {
    link::EndpointOptions options;
    options.items_per_tick = 50;
    return options;
}

/// Copies what the host sends, lets somebody send, and keeps both from knowing of it.
class Tapped final : public Carrier {
public:
    explicit Tapped(std::unique_ptr<Carrier> carrier) : carrier_(std::move(carrier)) {}
    void send(std::size_t end, std::span<const std::uint8_t> bytes, std::int64_t now_ns) override {
        if (end == 0) {
            heard.emplace_back(bytes.begin(), bytes.end());
        }
        carrier_->send(end, bytes, now_ns);
    }
    void receive(std::size_t end, std::int64_t now_ns, std::vector<std::uint8_t>& out) override {
        if (end == 1 && each_tick) {
            each_tick(now_ns);
        }
        carrier_->receive(end, now_ns, out);
    }
    void inject(std::span<const std::uint8_t> bytes, std::int64_t now_ns) { carrier_->send(0, bytes, now_ns); }
    void reset(std::size_t end) override { carrier_->reset(end); }
    [[nodiscard]] std::int64_t message_ns(std::span<const std::uint8_t> cobs) const override {
        return carrier_->message_ns(cobs);
    }
    [[nodiscard]] bool shared_by_both() const override { return carrier_->shared_by_both(); }

    std::vector<std::vector<std::uint8_t>> heard;
    std::function<void(std::int64_t)> each_tick;

private:
    std::unique_ptr<Carrier> carrier_;
};

host::ClientOptions with_key(std::optional<crypto::Key> key = kKey, std::uint32_t session = 5) {
    host::ClientOptions options;
    options.session = session;
    options.key = key;
    return options;
}

void serve(LinkWorld& world, const host::StreamJob& job, bool begun, const host::ClientOptions& options) {
    host::CellClient client(world, options);
    client.connect();
    host::Session session(client, {});
    if (!begun) {
        session.run(job, nullptr);
        return;
    }
    const host::Session::Standing standing = session.look(job, std::nullopt);
    if (standing.kind == host::Session::Standing::Kind::under_way) {
        session.rejoin(job, nullptr);
    } else if (standing.kind == host::Session::Standing::Kind::broken_off) {
        session.clear();
        session.run(job, nullptr, host::resume_point(job.items, standing.place.certain));
    }
}

/// One host after another until the job is done; how many.
int burn(LinkWorld& world, const std::vector<Item>& items) {
    const host::StreamJob job{job_hash(items), items, 0.0};
    for (int hosts = 1; hosts < 60; ++hosts) {
        try {
            serve(world, job, hosts > 1, with_key());
            return hosts;
        } catch (const host::CellError&) {
            world.live_alone(200 * kMs);
        }
    }
    return 0;
}

/// Each point of the job once, in order.
void expect_burnt_once(const CellEnd& cell, std::uint32_t points) {
    ASSERT_EQ(cell.burnt().size(), points);
    for (std::uint32_t k = 0; k < points; ++k) {
        ASSERT_EQ(cell.burnt()[k].x, static_cast<std::int32_t>(k));
    }
}

struct Case {
    const char* carrier;
    double share;
};

class SealedCarriers : public testing::TestWithParam<Case> {};

TEST_P(SealedCarriers, AJobIsBurntOncePointByPoint) {
    const double p = GetParam().share;
    const sim::TroubleRates rates{.destroy = p, .lose = p, .repeat = p, .late = p, .swap = p, .spoil = p};
    const auto carrier = make_carrier(GetParam().carrier, sim::Troubles(rates, {}, 3));
    CellEnd cell(endpoint_options(), 50, kKey);
    LinkWorld world(*carrier, cell);
    constexpr std::uint32_t kPoints = 20'000;
    EXPECT_GT(burn(world, job_of(kPoints)), 0);
    expect_burnt_once(cell, kPoints);
    if (p == 0.0) {
        EXPECT_EQ(cell.endpoint().counters().seals.dropped, 0U) << "the host keeps to what the controller can check";
        EXPECT_EQ(cell.endpoint().counters().seals.wrong, 0U);
    }
}

INSTANTIATE_TEST_SUITE_P(All, SealedCarriers,
                         testing::Values(Case{"serial_921k", 0.0}, Case{"serial_3m", 0.0}, Case{"fd_1m_5m", 0.0},
                                         Case{"classic_1m", 0.0}, Case{"serial_921k", 0.05}, Case{"fd_1m_5m", 0.05},
                                         Case{"serial_3m", 0.01}, Case{"classic_1m", 0.002}));

// The usual failure in the field: freshness that is out of step after a reset or a bus that was off.
TEST(SealedLink, GoesOnAfterResetsKilledHostsAndALineThatWasOff) {
    for (const char* name : {"serial_921k", "fd_1m_5m"}) {
        const std::vector<sim::Partition> cuts{{700 * kMs, 760 * kMs}, {2000 * kMs, 2400 * kMs}};
        const auto carrier = make_carrier(name, sim::Troubles({}, cuts, 4));
        CellEnd cell(endpoint_options(), 4, kKey);
        LinkWorld world(*carrier, cell);
        world.host_kills_ns = {1200 * kMs, 4300 * kMs};
        world.cell_resets_ns = {1600 * kMs, 3500 * kMs, 5100 * kMs};
        constexpr std::uint32_t kPoints = 30'000;
        EXPECT_GT(burn(world, job_of(kPoints)), 1) << name;
        expect_burnt_once(cell, kPoints);
    }
}

TEST(SealedLink, ALineThatWasOffForLongerThanTheSessionNeedsNoNewHost) {
    const auto carrier = make_carrier("serial_921k", sim::Troubles({}, {{1000 * kMs, 1500 * kMs}}, 4));
    CellEnd cell(endpoint_options(), 4, kKey);
    LinkWorld world(*carrier, cell);
    EXPECT_EQ(burn(world, job_of(20'000)), 1);
    expect_burnt_once(cell, 20'000);
}

template <class Message>
std::vector<std::uint8_t> forged(const Message& message, std::uint16_t counter) {
    std::vector<std::uint8_t> bytes(link::kSerialCapacity);
    bytes.resize(link::encode_serial(message, counter, bytes));
    return bytes;
}

TEST(SealedLink, SomebodyElseOnTheBusGetsNothingDone) {
    for (const char* name : {"serial_921k", "classic_1m", "fd_1m_5m"}) {
        Tapped tap(make_carrier(name, {}));
        CellEnd cell(endpoint_options(), 4, kKey);
        LinkWorld world(tap, cell);
        std::size_t replayed = 0;
        std::uint32_t number = 0;
        tap.each_tick = [&](std::int64_t now) {
            ++number;
            const auto counter = static_cast<std::uint16_t>(number * 7);
            const auto own = [&](const auto& message) { tap.inject(forged(message, counter), now); };
            switch (number % 60) {
                case 5: own(link::Heartbeat{1}); break;
                case 10: own(link::Command{number, static_cast<std::uint8_t>(link::Verb::abort), 0, 0, 0}); break;
                case 15: own(link::Command{number, static_cast<std::uint8_t>(link::Verb::enable), 0, 0, 0}); break;
                case 20: own(link::JobOpen{number, 1, 2}); break;
                case 25: own(link::SealHello{.session = 5, .challenge = 1}); break;
                case 30: own(link::Hello{.schema = link::kSchemaHash, .session = 66}); break;
                case 40:
                    if (tap.heard.size() > 40) {
                        replayed = (replayed + 1) % (tap.heard.size() - 20);
                        tap.inject(tap.heard[replayed], now);
                    }
                    break;
                default: break;
            }
        };
        constexpr std::uint32_t kPoints = 10'000;
        EXPECT_EQ(burn(world, job_of(kPoints)), 1) << name;
        expect_burnt_once(cell, kPoints);
        EXPECT_GT(cell.endpoint().counters().seals.wrong + cell.endpoint().counters().seals.stale, 50U) << name;
    }
}

TEST(SealedLink, WithoutAHostTheSomebodyGetsNothingDoneEither) {
    Tapped tap(make_carrier("serial_921k", {}));
    CellEnd cell(endpoint_options(), 4, kKey);
    LinkWorld world(tap, cell);
    EXPECT_EQ(burn(world, job_of(500)), 1);
    cell.forget_burnt();
    const auto all = tap.heard;
    tap.reset(0);
    std::size_t next = 0;
    tap.each_tick = [&](std::int64_t now) {
        if (next < all.size()) {
            tap.inject(all[next++], now);
        }
    };
    world.live_alone(static_cast<std::int64_t>(all.size() + 300) * kMs);
    EXPECT_EQ(next, all.size()) << "the whole session, said again";
    EXPECT_TRUE(cell.burnt().empty());
    EXPECT_FALSE(cell.endpoint().alive(1'000'000));
}

Refusal refused(std::optional<crypto::Key> host_key, std::optional<crypto::Key> cell_key,
                std::uint8_t newest_minor = link::kProtocolMinor) {
    const auto carrier = make_carrier("serial_921k", {});
    link::EndpointOptions options = endpoint_options();
    options.newest_minor = newest_minor;
    CellEnd cell(options, 4, cell_key);
    LinkWorld world(*carrier, cell);
    host::CellClient client(world, with_key(host_key));
    try {
        client.connect();
    } catch (const host::CellRefused& refusal) {
        EXPECT_FALSE(cell.endpoint().session_open()) << "an unsealed session was opened";
        return refusal.refusal;
    }
    return Refusal::none;
}

TEST(SealedLink, BothHaveTheKeyOrNeither) {
    crypto::Key other = kKey;
    other[0] ^= 1;
    EXPECT_EQ(refused(kKey, kKey), Refusal::none);
    EXPECT_EQ(refused({}, {}), Refusal::none);
    EXPECT_EQ(refused({}, kKey), Refusal::seal_required);
    EXPECT_EQ(refused(kKey, {}), Refusal::seal_not_fitted);
    EXPECT_EQ(refused(other, kKey), Refusal::seal_wrong_key);
    EXPECT_EQ(refused(kKey, {}, 2), Refusal::seal_not_fitted) << "a controller of an older version";
    EXPECT_EQ(refused({}, {}, 2), Refusal::none);
}

}  // namespace
