// SPDX-License-Identifier: Apache-2.0
// The figures of `scribecell bench link` that need both ends of the link in one process: the host's real client,
// streamer and session, the controller's real endpoint, and a mock carrier between them in virtual time.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "host/bridge/client.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/session.hpp"
#include "host/formats/error.hpp"
#include "shared/link/blocks.hpp"
#include "shared/path/job_hash.hpp"
#include "tests/bench/link/link_world.hpp"
#include "tests/bench/link/oracle.hpp"

namespace {

using namespace sc;         // NOLINT(google-build-using-namespace): a program of its own
using namespace sc::bench;  // NOLINT(google-build-using-namespace): the same

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::uint32_t kSession = 77;

std::vector<Item> whole_job(std::vector<std::vector<PathPoint>> paths) {
    std::vector<Item> items{Turn{0}};
    std::uint32_t id = 0;
    for (const std::vector<PathPoint>& path : paths) {
        PathBegin begin;
        begin.path = ++id;
        items.emplace_back(begin);
        items.insert(items.end(), path.begin(), path.end());
        items.emplace_back(PathEnd{});
    }
    items.emplace_back(JobEnd{});
    return items;
}

/// The dense workload of the motion benchmark, again and again.
std::vector<Item> dense_job(const std::string& file, std::size_t points) {
    std::ifstream in(file);
    std::vector<PathPoint> path;
    std::string line;
    std::getline(in, line);
    const auto wire = [](double mm) { return static_cast<std::int32_t>(std::llround(mm * 1e-3 * kWireUnitsPerMetre)); };
    while (std::getline(in, line)) {
        double x = 0.0;
        double y = 0.0;
        double z = 0.0;
        if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &x, &y, &z) == 3) {
            path.push_back({wire(x), wire(y), wire(z)});
        }
    }
    if (path.size() < 1000) {
        throw std::runtime_error(file + " holds no dense workload");
    }
    std::vector<std::vector<PathPoint>> paths;
    for (std::size_t count = 0; count < points; count += path.size()) {
        paths.push_back(path);
    }
    return whole_job(std::move(paths));
}

std::vector<Item> numbered_job(std::uint32_t points) {
    constexpr std::uint32_t kPerPath = 2000;
    std::vector<std::vector<PathPoint>> paths;
    for (std::uint32_t k = 0; k < points; ++k) {
        if (k % kPerPath == 0) {
            paths.emplace_back();
        }
        paths.back().push_back({static_cast<std::int32_t>(k), static_cast<std::int32_t>(k % 7), 1});
    }
    return whole_job(std::move(paths));
}

std::size_t points_of(const std::vector<Item>& items) {
    return static_cast<std::size_t>(
        std::count_if(items.begin(), items.end(), [](const Item& i) { return std::holds_alternative<PathPoint>(i); }));
}

host::SessionOptions session_options(std::uint32_t items_per_block) {
    host::SessionOptions options;
    options.stream.items_per_block = items_per_block;
    return options;
}

/// What one host does with a job, begun before or not.
void serve(LinkWorld& world, const host::StreamJob& job, std::uint32_t items_per_block, bool begun) {
    host::CellClient client(world, {.session = kSession});
    client.connect();
    host::Session session(client, session_options(items_per_block));
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

struct Ends {
    std::uint32_t hosts = 0;   ///< that were needed
    std::uint32_t errors = 0;  ///< of those ended by themselves
    bool done = false;
};

/// One host after another, until the job is burnt or refused.
Ends burn(LinkWorld& world, CellEnd& cell, const std::vector<Item>& items, std::uint32_t items_per_block) {
    constexpr std::uint32_t kMostHosts = 400;
    const host::StreamJob job{job_hash(items), items, 0.0};
    Ends ends;
    while (!ends.done && ends.hosts < kMostHosts && !cell.refused()) {
        try {
            serve(world, job, items_per_block, ends.hosts > 0);
            ends.done = true;
        } catch (const host::CellError& error) {
            // The host has been killed, or the cell reset.
            ++ends.errors;
            if (std::getenv("SC_LINK_BENCH_ERRORS") != nullptr) {
                std::fprintf(stderr, "host %u: %s\n", ends.hosts, error.what());
            }
            world.live_alone(kSecond / 5);
        } catch (const host::InputError& error) {
            // The cell names a place that is none of the job's: nobody can go on from there.
            std::fprintf(stderr, "host %u: %s\n", ends.hosts, error.what());
            return ends;
        }
        ++ends.hosts;
    }
    return ends;
}

// --- throughput

/// Points a second that the carrier could bring without trouble: the blocks back to back on a bus that is never idle,
/// less the host's heartbeats, and less `back`, the share of the time that the cell's own messages take of a bus that
/// both directions share.
double limit_of(const Carrier& carrier, const std::vector<Item>& items, double back) {
    const std::uint64_t hash = job_hash(items);
    std::array<std::uint8_t, link::kSerialCapacity> bytes{};
    const auto time_of = [&](const auto& message) {
        return static_cast<double>(carrier.message_ns(std::span(bytes).first(link::encode_serial(message, 1, bytes))));
    };
    double blocks_ns = 0.0;
    for (std::uint32_t first = 0; first < items.size();) {
        const link::Block block = link::make_block(hash, items, first);
        blocks_ns += time_of(block);
        first += block.count;
    }
    const double heartbeat = time_of(link::Heartbeat{1'000'000}) / 25e6;
    return static_cast<double>(points_of(items)) / (blocks_ns * 1e-9) * (1.0 - heartbeat - back);
}

struct Throughput {
    double share = 0.0;
    double points_per_s = 0.0;
    double limit = 0.0;
    double back = 0.0;  ///< share of the bus that the cell's own messages took
};

Throughput throughput(const std::string& name, const std::vector<Item>& items, std::uint64_t seed,
                      const link::EndpointOptions& options = {}) {
    constexpr std::uint32_t kUnlimited = 1'000'000;
    // A frame that is destroyed: on CAN an error frame and again; on a line it is gone.
    const sim::TroubleRates rates{.destroy = 0.01};
    const auto carrier = make_carrier(name, sim::Troubles(rates, {}, seed));
    link::EndpointOptions fast = options;
    fast.items_per_tick = kUnlimited;
    CellEnd cell(fast, kUnlimited);
    LinkWorld world(*carrier, cell);
    if (!burn(world, cell, items, 0).done) {
        throw std::runtime_error(name + ": the job does not end");
    }
    Throughput result;
    const double seconds = static_cast<double>(cell.last_burn_tick() - cell.first_burn_tick()) * 1e-3;
    // What had come before the first tick has not come within these seconds.
    result.points_per_s = static_cast<double>(cell.burnt().size() - cell.burnt_at_first()) / seconds;
    result.back = carrier->shared_by_both() ? 1e-9 * static_cast<double>(world.cell_said_ns()) / seconds : 0.0;
    result.limit = limit_of(*carrier, items, result.back);
    result.share = result.points_per_s / result.limit;
    return result;
}

double bytes_per_point(const std::vector<Item>& items) {
    const std::uint64_t hash = job_hash(items);
    std::array<std::uint8_t, link::kSerialCapacity> bytes{};
    double sum = 0.0;
    for (std::uint32_t first = 0; first < items.size();) {
        const link::Block block = link::make_block(hash, items, first);
        sum += static_cast<double>(link::encode_serial(block, 1, bytes));
        first += block.count;
    }
    return sum / static_cast<double>(points_of(items));
}

// --- a link that comes back

/// From the moment the line is whole again to the next point that is burnt.
double resume_seconds(const std::string& name, std::uint64_t seed) {
    constexpr std::int64_t kCut = 3 * kSecond;
    constexpr std::int64_t kBack = kCut + kSecond / 2;
    const std::vector<Item> items = numbered_job(40'000);
    const auto carrier = make_carrier(name, sim::Troubles({}, {{kCut, kBack}}, seed));
    constexpr std::uint32_t kBurnsPerTick = 4;
    CellEnd cell({}, kBurnsPerTick);
    LinkWorld world(*carrier, cell);
    world.when_reached(kBack, [&cell] { cell.forget_times(); });
    if (!burn(world, cell, items, 0).done) {
        throw std::runtime_error(name + ": the job does not go on");
    }
    return static_cast<double>(cell.first_burn_tick()) * 1e-3 - static_cast<double>(kBack) * 1e-9;
}

// --- the campaign

struct Campaign {
    Tally tally;
    std::uint64_t hosts = 0;
    std::uint64_t jobs_not_done = 0;
};

/// Jobs over one carrier with everything that may go wrong, until so many points have been sent.
void campaign(const std::string& name, std::uint64_t points, std::uint64_t seed, const link::StreamRules& rules,
              Campaign& sum) {
    constexpr std::uint32_t kPointsPerJob = 250'000;
    constexpr std::uint32_t kUnlimited = 1'000'000;
    // A message of 36 classic frames would hardly ever arrive whole: short ones there.
    const std::uint32_t items_per_block = name == "classic_1m" ? 10 : 0;
    const sim::TroubleRates rates{
        .destroy = 0.05, .lose = 0.05, .repeat = 0.05, .late = 0.05, .swap = 0.05, .spoil = 0.05};
    for (std::uint64_t done = 0; done < points; done += kPointsPerJob) {
        ++seed;
        sim::Troubles draw({}, {}, seed);
        const auto count = static_cast<std::uint32_t>(std::min<std::uint64_t>(kPointsPerJob, points - done));
        std::vector<sim::Partition> cuts;
        std::vector<std::int64_t> kills;
        std::vector<std::int64_t> resets;
        std::int64_t at = kSecond;
        for (int i = 0; i < 60; ++i) {
            at += kSecond / 2 + draw.up_to(2 * kSecond);
            if (i % 3 == 0) {
                cuts.push_back({at, at + draw.up_to(kSecond / 2)});
            } else {
                (i % 3 == 1 ? kills : resets).push_back(at);
            }
        }
        const auto carrier = make_carrier(name, sim::Troubles(rates, cuts, seed));
        CellEnd cell({.rules = rules, .items_per_tick = kUnlimited}, kUnlimited);
        LinkWorld world(*carrier, cell);
        world.host_kills_ns = kills;
        world.cell_resets_ns = resets;
        const Ends ends = burn(world, cell, numbered_job(count), items_per_block);
        sum.tally.add(count, cell.burnt());
        sum.hosts += ends.hosts;
        sum.jobs_not_done += ends.done ? 0U : 1U;
        std::fprintf(stderr, "%s: %llu points, %llu hosts\n", name.c_str(),
                     static_cast<unsigned long long>(sum.tally.points), static_cast<unsigned long long>(sum.hosts));
    }
}

// --- output

class Json {
public:
    void add(const std::string& name, double value) {
        std::printf("%s\n  \"%s\": %.9g", first_ ? "{" : ",", name.c_str(), value);
        std::fflush(stdout);
        first_ = false;
    }
    void end() const { std::printf("\n}\n"); }

private:
    bool first_ = true;
};

void measure(const std::string& dense, double scale, std::uint64_t seed) {
    Json json;
    const std::map<std::string, std::size_t> carriers{
        {"classic_1m", 240'000}, {"fd_1m_5m", 1'200'000}, {"serial_921k", 480'000}, {"serial_3m", 1'200'000}};
    double slowest_resume = 0.0;
    for (const auto& [name, points] : carriers) {
        const auto count = std::max<std::size_t>(static_cast<std::size_t>(static_cast<double>(points) * scale), 20'000);
        const std::vector<Item> items = dense_job(dense, count);
        const Throughput result = throughput(name, items, seed);
        json.add(name + "_share", result.share);
        json.add(name + "_points_per_s", result.points_per_s);
        json.add(name + "_limit", result.limit);
        json.add(name + "_back_share", result.back);
        slowest_resume = std::max(slowest_resume, resume_seconds(name, seed));
    }
    const std::vector<Item> items = dense_job(dense, 20'000);
    json.add("bytes_per_point", bytes_per_point(items));
    json.add("resume_s", slowest_resume);
    const link::EndpointOptions older{.rules = {.keeps_ahead = false}, .newest_minor = 0};
    json.add("go_back_n_share", throughput("serial_921k", dense_job(dense, 120'000), seed, older).share);

    Campaign sum;
    const auto part = [scale](double points) { return static_cast<std::uint64_t>(points * scale); };
    campaign("serial_3m", part(6e6), seed, {}, sum);
    campaign("fd_1m_5m", part(3.5e6), seed + 1000, {}, sum);
    campaign("classic_1m", part(5e5), seed + 2000, {}, sum);
    json.add("campaign_points", static_cast<double>(sum.tally.points));
    json.add("lost", static_cast<double>(sum.tally.lost));
    json.add("doubled", static_cast<double>(sum.tally.doubled));
    json.add("reordered", static_cast<double>(sum.tally.reordered));
    json.add("foreign", static_cast<double>(sum.tally.foreign));
    json.add("campaign_hosts", static_cast<double>(sum.hosts));
    json.add("campaign_jobs_not_done", static_cast<double>(sum.jobs_not_done));

    Campaign blind;
    campaign("serial_3m", 20'000, seed, {.checks_index = false}, blind);
    json.add("no_index_check_wrong",
             static_cast<double>(blind.tally.doubled + blind.tally.lost + blind.tally.reordered));
    json.end();
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2 || argc > 4) {
        std::fprintf(stderr, "usage: scribecell-link-bench DENSE.csv [SCALE [SEED]]\n");
        return 2;
    }
    try {
        measure(argv[1], argc > 2 ? std::atof(argv[2]) : 1.0, argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-link-bench: %s\n", error.what());
        return 1;
    }
}
