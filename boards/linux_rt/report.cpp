// SPDX-License-Identifier: Apache-2.0
#include "boards/linux_rt/report.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace sc::linux_rt {
namespace {

using Json = nlohmann::ordered_json;

const char* name_of(socketcan::BusState state) {
    switch (state) {
        case socketcan::BusState::active: return "active";
        case socketcan::BusState::warning: return "warning";
        case socketcan::BusState::passive: return "passive";
        case socketcan::BusState::bus_off: return "bus-off";
        case socketcan::BusState::down: return "down";
    }
    return "";
}

Json json_of(const Histogram& h) {
    Json buckets = Json::object();
    for (std::size_t us = 0; us <= Histogram::kBuckets; ++us) {
        if (h.at(us) > 0) {
            buckets[us == Histogram::kBuckets ? ">=1000" : std::to_string(us)] = h.at(us);
        }
    }
    return {{"count", h.count()},
            {"mean_us", h.mean_us()},
            {"p50_us", h.quantile_us(0.5)},
            {"p99_us", h.quantile_us(0.99)},
            {"p999_us", h.quantile_us(0.999)},
            {"max_us", static_cast<double>(h.max_ns()) * 1e-3},
            {"us", buckets}};
}

Json json_of(const socketcan::CanSocket& bus) {
    const socketcan::CanCounters& c = bus.counters();
    return {{"state", name_of(bus.state())},
            {"sent", c.sent},
            {"received", c.received},
            {"full", c.full},
            {"down", c.down},
            {"failed", c.failed},
            {"malformed", c.malformed},
            {"dropped", c.dropped},
            {"errors", c.errors},
            {"bus_offs", c.bus_offs},
            {"restarts", c.restarts},
            {"no_acks", c.no_acks},
            {"lost_arbitrations", c.lost_arbitrations},
            {"overflows", c.overflows}};
}

std::string line_of(const char* what, const Histogram& h) {
    return fmt::format("{}: mean {:.1f}, 50 % within {}, 99.9 % within {}, most {:.1f} us\n", what, h.mean_us(),
                       h.quantile_us(0.5), h.quantile_us(0.999), static_cast<double>(h.max_ns()) * 1e-3);
}

}  // namespace

std::string to_json(const RunFigures& f) {
    const LoopReport loop = f.loop->report();
    const DriveBusCounters& drives = f.drives->counters();
    Json buses = Json::array();
    for (const socketcan::CanSocket& bus : f.drives->buses()) {
        buses.push_back(json_of(bus));
    }
    Json link{{"name", f.link->name()},
              {"bytes_in", f.link->counters().bytes_in},
              {"bytes_out", f.link->counters().bytes_out},
              {"lost", f.link->counters().lost}};
    if (f.link->can() != nullptr) {
        link["can"] = json_of(*f.link->can());
    }
    Json json{
        {"ticks", f.runner->ticks()},
        {"state", sc::name_of(loop.state)},
        {"first_fault", static_cast<int>(loop.first_fault)},
        {"overruns", f.runner->pacer().overruns()},
        {"allocations", f.runner->allocations()},
        {"vetoes", loop.vetoes},
        {"lines", {{"edges", loop.lines.edges}, {"glitches", loop.lines.glitches}, {"missed", loop.lines.missed}}},
        {"drives",
         {{"unsent", drives.unsent},
          {"held", drives.held},
          {"foreign", drives.foreign},
          {"unanswered", drives.unanswered},
          {"buses", buses}}},
        {"link", link}};
    if (f.events != nullptr) {
        const event_device::EventCounters& c = f.events->counters();
        json["events"] = {{"windows", c.windows},
                          {"statuses", c.statuses},
                          {"malformed", c.malformed},
                          {"full", c.full},
                          {"lost", f.events->lost()}};
    }
    json["late"] = json_of(f.runner->pacer().late());
    json["work"] = json_of(f.runner->pacer().work());
    return json.dump();
}

std::string to_text(const RunFigures& f) {
    const LoopReport loop = f.loop->report();
    const DriveBusCounters& drives = f.drives->counters();
    std::string text = fmt::format("{} ticks, {} overruns, {} allocations in the loop; state {}, first fault {}\n",
                                   f.runner->ticks(), f.runner->pacer().overruns(), f.runner->allocations(),
                                   sc::name_of(loop.state), static_cast<int>(loop.first_fault));
    text += line_of("began late", f.runner->pacer().late());
    text += line_of("work", f.runner->pacer().work());
    text += fmt::format("drives: {} frames not sent, {} SYNCs without an answer\n", drives.unsent, drives.unanswered);
    for (const socketcan::CanSocket& bus : f.drives->buses()) {
        const socketcan::CanCounters& c = bus.counters();
        text += fmt::format("  bus {}: {} sent, {} received, queue full {}, down {}, error frames {}, bus-off {}\n",
                            name_of(bus.state()), c.sent, c.received, c.full, c.down, c.errors, c.bus_offs);
    }
    text += fmt::format("link {}: {} bytes in, {} out, {} lost\n", f.link->name(), f.link->counters().bytes_in,
                        f.link->counters().bytes_out, f.link->counters().lost);
    text += fmt::format("lines: {} edges, {} glitches, {} changes without an edge; {} vetoes of the guard\n",
                        loop.lines.edges, loop.lines.glitches, loop.lines.missed, loop.vetoes);
    if (f.events != nullptr) {
        text +=
            fmt::format("event device: {} windows{}\n", f.events->counters().windows, f.events->lost() ? ", lost" : "");
    }
    return text;
}

}  // namespace sc::linux_rt
