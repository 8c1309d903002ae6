// SPDX-License-Identifier: Apache-2.0
// An endpoint behind a bad line: frames are lost, repeated, overtaken and spoilt in both directions, and a host that
// knows nothing but the acknowledgements sends until all has arrived.
#include "firmware/link/endpoint.hpp"

#include <deque>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "shared/link/blocks.hpp"
#include "shared/path/job_hash.hpp"
#include "tests/unit/firmware/link/link_host.hpp"

namespace {

using namespace sc::link;  // NOLINT(google-build-using-namespace): the subject of this file
using sc::Item;
using Random = std::mt19937_64;
using Frame = std::vector<std::uint8_t>;

/// A line that spoils each frame with the given chance in a thousand.
struct Line {
    Random& random;
    unsigned loss = 0;
    unsigned repeat = 0;
    unsigned swap = 0;
    unsigned corrupt = 0;
    std::deque<Frame> under_way;

    void put(Frame frame) {
        if (chance(loss)) {
            return;
        }
        const bool twice = chance(repeat);
        if (chance(corrupt)) {
            for (std::uint64_t i = 0; i <= random() % 4; ++i) {
                frame[random() % frame.size()] = static_cast<std::uint8_t>(random());
            }
        }
        if (twice) {
            under_way.push_back(frame);
        }
        under_way.push_back(std::move(frame));
        if (under_way.size() > 1 && chance(swap)) {
            std::swap(under_way.back(), under_way[random() % under_way.size()]);
        }
    }
    Frame get() {
        if (under_way.empty()) {
            return {};
        }
        Frame frame = std::move(under_way.front());
        under_way.pop_front();
        return frame;
    }
    bool chance(unsigned per_thousand) const { return random() % 1000 < per_thousand; }
};

std::vector<Item> random_job(Random& random, std::size_t count) {
    std::vector<Item> items;
    std::int32_t x = 0;
    while (items.size() + 1 < count) {
        x += static_cast<std::int32_t>(random() % 5000);
        items.emplace_back(random() % 200 == 0 ? Item{sc::PathEnd{}} : Item{sc::PathPoint{x, -x, 7}});
    }
    items.emplace_back(sc::JobEnd{});
    return items;
}

struct Campaign {
    unsigned loss;
    unsigned repeat;
    unsigned swap;
    unsigned corrupt;
    std::size_t drain;  ///< items the planner takes a tick
};

class Exchange {
public:
    Exchange(const Campaign& campaign, std::uint64_t seed)
        : random_(seed),
          down_{random_, campaign.loss, campaign.repeat, campaign.swap, campaign.corrupt, {}},
          up_{random_, campaign.loss, campaign.repeat, campaign.swap, campaign.corrupt, {}},
          items_(random_job(random_, 6000)),
          job_(sc::job_hash(items_)),
          drain_(campaign.drain) {
        host_.send(*endpoint_, 0, hello_of(1));
        endpoint_->open_job(job_, static_cast<std::uint32_t>(items_.size()));
    }

    /// Runs until the planner has taken every item; false when that does not end.
    bool run() {
        for (tick_ = 1; tick_ < 60'000 && taken.size() < items_.size(); ++tick_) {
            host_tick();
            cell_tick();
        }
        return taken.size() == items_.size();
    }
    [[nodiscard]] const std::vector<Item>& items() const { return items_; }
    [[nodiscard]] const Endpoint& endpoint() const { return *endpoint_; }

    std::vector<Item> taken;

private:
    /// One block a tick, from where the last acknowledgement says; after 20 quiet ticks back to what it wants, and now
    /// and then back to some item long received.
    void host_tick() {
        host_.take(up_.get());
        for (const StreamAck& ack : host_.acks) {
            if (ack.received > acked_) {
                acked_ = ack.received;
                quiet_ = 0;
            }
            if (ack.received == acked_) {
                limit_ = ack.received + ack.free_items;
            }
        }
        host_.clear();
        next_ = ++quiet_ > 20 ? acked_ : std::max(next_, acked_);
        quiet_ = quiet_ > 20 ? 0 : quiet_;
        if (random_() % 50 == 0) {
            next_ = acked_ - static_cast<std::uint32_t>(random_() % (std::min(acked_, 100U) + 1));
        }
        if (next_ < std::min<std::size_t>(limit_, items_.size())) {
            const Block block = make_block(job_, items_, next_);
            next_ += block.count;
            down_.put(host_.framed(block));
        } else if (tick_ % 20 == 0) {
            down_.put(host_.framed(Heartbeat{1}));
        }
    }
    void cell_tick() {
        endpoint_->receive(tick_, down_.get());
        for (std::size_t i = 0; i < drain_ && endpoint_->items().front() != nullptr; ++i) {
            taken.push_back(*endpoint_->items().front());
            endpoint_->items().pop();
        }
        endpoint_->progress(static_cast<std::uint32_t>(taken.size()), 0, {});
        Frame bytes(1024);
        bytes.resize(endpoint_->transmit(bytes));
        if (!bytes.empty()) {
            up_.put(bytes);
        }
    }

    Random random_;
    Line down_;
    Line up_;
    std::vector<Item> items_;
    std::uint64_t job_;
    std::size_t drain_;
    std::unique_ptr<Endpoint> endpoint_ = std::make_unique<Endpoint>(sc::reference_machine(), 1);
    LinkHost host_;
    std::int64_t tick_ = 0;
    std::uint32_t acked_ = 0;
    std::uint32_t next_ = 0;
    std::uint32_t limit_ = 0;
    int quiet_ = 0;
};

TEST(EndpointProperty, EveryItemArrivesOnceAndInOrderOverABadLine) {
    const std::vector<Campaign> campaigns{
        {0, 0, 0, 0, 100},   {50, 0, 0, 0, 100},   {0, 200, 0, 0, 100},    {0, 0, 200, 0, 100},
        {0, 0, 0, 100, 100}, {50, 50, 50, 50, 30}, {100, 100, 100, 50, 7}, {50, 50, 50, 50, 2000},
    };
    std::uint32_t repeated = 0;
    std::uint32_t ahead = 0;
    std::uint32_t bad = 0;
    std::uint64_t seed = 100;
    for (const Campaign& campaign : campaigns) {
        SCOPED_TRACE("seed " + std::to_string(++seed));
        Exchange exchange(campaign, seed);
        ASSERT_TRUE(exchange.run()) << exchange.taken.size() << " items arrived";
        EXPECT_EQ(exchange.taken, exchange.items());
        EXPECT_TRUE(exchange.endpoint().job_hash_ok());
        EXPECT_EQ(exchange.endpoint().job_refusal(), sc::Refusal::none);
        const LinkCounters counters = exchange.endpoint().counters();
        repeated += counters.items_repeated;
        ahead += counters.blocks_ahead;
        bad += counters.frames_bad;
    }
    EXPECT_GT(repeated, 100U) << "the campaign must have repeated items";
    EXPECT_GT(ahead, 100U) << "and lost blocks";
    EXPECT_GT(bad, 100U) << "and spoilt frames";
}

TEST(EndpointProperty, RandomBytesAndRandomMessagesNeverTakeTheEndpointApart) {
    Random random(77);  // NOLINT(cert-msc32-c,cert-msc51-cpp): a fixed seed repeats
    const auto endpoint = std::make_unique<Endpoint>(sc::reference_machine(), 1);
    LinkHost host;
    std::uint32_t events = 0;
    for (std::int64_t tick = 0; tick < 20'000; ++tick) {
        Frame bytes;
        switch (random() % 8) {
            case 0: bytes = host.framed(hello_of(static_cast<std::uint32_t>(random() % 2))); break;
            case 1: bytes = host.framed(Command{static_cast<std::uint32_t>(tick / 3), 1, 0, 0, 0}); break;
            case 2: bytes = host.framed(ConfigRequest{static_cast<std::uint16_t>(random())}); break;
            case 3: {
                Block block;
                block.job_low = 5;
                block.first = static_cast<std::uint32_t>(random() % 50);
                block.count = static_cast<std::uint8_t>(random() % 20);
                block.items.size = block.count;
                block.items.data.fill(sc::block_tag::kPathEnd);
                bytes = host.framed(block);
                break;
            }
            default:
                bytes.resize(random() % 200);
                for (std::uint8_t& byte : bytes) {
                    byte = static_cast<std::uint8_t>(random());
                }
        }
        if (random() % 4 == 0 && !bytes.empty()) {
            bytes.resize(random() % bytes.size());
        }
        endpoint->receive(tick, bytes);
        LinkEvent event;
        while (random() % 3 != 0 && endpoint->poll(event)) {
            ++events;
            endpoint->reply(event.command.sequence, sc::Refusal::none, 0);
        }
        if (tick % 100 == 0) {
            endpoint->open_job(5, 60);
        }
        ASSERT_LE(endpoint->received(), 60U);
        ASSERT_LE(endpoint->items().size(), 60U);
        Frame out(random() % 300);
        host.take(std::span(out).first(endpoint->transmit(out)));
    }
    EXPECT_GT(events, 500U);
    EXPECT_EQ(host.malformed, 0);
    EXPECT_EQ(host.frames_bad(), 0U) << "all that it sends is well formed";
}

}  // namespace
