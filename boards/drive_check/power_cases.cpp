// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdlib>

#include "boards/drive_check/cases.hpp"

namespace sc::drive_check {
namespace {

constexpr std::uint16_t kBit10 = 0x0400;
constexpr std::uint16_t kBit12 = 0x1000;
constexpr std::uint16_t kBit13 = 0x2000;

struct Transition {
    Power from;
    std::uint16_t word;
    Power to;
    Power or_to;  ///< allowed too (a drive may make two steps at once)
};
constexpr Transition kTransitions[] = {
    {Power::disabled, 0x06, Power::ready, Power::ready},
    {Power::disabled, 0x07, Power::disabled, Power::disabled},
    {Power::disabled, 0x0F, Power::disabled, Power::disabled},
    {Power::disabled, 0x00, Power::disabled, Power::disabled},
    {Power::ready, 0x07, Power::switched_on, Power::switched_on},
    {Power::ready, 0x0F, Power::switched_on, Power::enabled},
    {Power::ready, 0x00, Power::disabled, Power::disabled},
    {Power::ready, 0x02, Power::disabled, Power::disabled},
    {Power::switched_on, 0x0F, Power::enabled, Power::enabled},
    {Power::switched_on, 0x06, Power::ready, Power::ready},
    {Power::switched_on, 0x00, Power::disabled, Power::disabled},
    {Power::switched_on, 0x02, Power::disabled, Power::disabled},
    {Power::enabled, 0x0F, Power::enabled, Power::enabled},
    {Power::enabled, 0x07, Power::switched_on, Power::switched_on},
    {Power::enabled, 0x06, Power::ready, Power::ready},
    {Power::enabled, 0x00, Power::disabled, Power::disabled},
    {Power::enabled, 0x02, Power::disabled, Power::quick_stop},
};

Result try_transition(DriveClient& d, const Transition& t) {
    if (!d.operational() || !d.go_to(t.from)) {
        return failed("it does not come to " + name_of(t.from) + ": " + name_of(d.power()));
    }
    // A step with a single word: the second step of a 0F would hide the first.
    d.control(t.word, d.actual(), 1);
    d.run(2);
    const Power now = d.power();
    return expect(now == t.to || now == t.or_to,
                  "from " + name_of(t.from) + " by " + hex(t.word) + " to " + name_of(now) + ", not " + name_of(t.to));
}

Result enabled(DriveClient& d) {
    if (!d.operational() || !d.go_to(Power::enabled)) {
        return failed("it cannot be enabled: " + name_of(d.power()));
    }
    return passed();
}

/// A fault that can be had from outside: the master's heartbeat falls silent.
std::vector<Frame> provoke(DriveClient& d) {
    constexpr std::uint32_t kMaster = 0x7F;
    d.write(0x1016, 1, 4, (kMaster << 16U) | 50U);
    d.send(0x700U + kMaster, {5});
    d.control(0x0F, d.actual(), 2);
    std::vector<Frame> all;
    for (int i = 0; i < 200 && d.power() != Power::fault; ++i) {
        for (Frame& frame : d.control(0x0F, d.actual(), 1)) {
            all.push_back(std::move(frame));
        }
    }
    return all;
}

void add_states(std::vector<Case>& list) {
    for (const Transition& t : kTransitions) {
        list.push_back({.group = "states",
                        .name = name_of(t.from) + ", " + hex(t.word).substr(6),
                        .moves = false,
                        .run = [t](DriveClient& d) { return try_transition(d, t); }});
    }
    const auto add = [&list](const char* name, std::function<Result(DriveClient&)> run) {
        list.push_back({.group = "states", .name = name, .moves = false, .run = std::move(run)});
    };
    add("a quick stop is not left by 0F (605A = 2)", [](DriveClient& d) {
        Result up = enabled(d);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        d.control(0x02, d.actual(), 1);
        d.control(0x0F, d.actual(), 5);
        return expect(d.power() != Power::enabled, "it is enabled again");
    });
    add("pre-operational takes the power away", [](DriveClient& d) {
        Result up = enabled(d);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        d.nmt(0x80);
        d.run_ms(200.0);
        const auto status = d.read(0x6041, 0);
        return expect(status && power_of(static_cast<std::uint16_t>(*status)) != Power::enabled, "it stays enabled");
    });
}

void add_faults(std::vector<Case>& list) {
    const auto add = [&list](const char* name, std::function<Result(DriveClient&)> run) {
        list.push_back({.group = "EMCY", .name = name, .moves = false, .run = std::move(run)});
    };
    add("the master's silence is a fault, with 8130", [](DriveClient& d) {
        Result up = enabled(d);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        const auto codes = d.emergencies(provoke(d));
        if (d.power() != Power::fault) {
            return failed("it stays " + name_of(d.power()));
        }
        return expect(std::ranges::find(codes, 0x8130) != codes.end(), "no EMCY 8130");
    });
    add("603F and 1001 say so", [](DriveClient& d) {
        Result up = enabled(d);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        provoke(d);
        return expect(d.read(0x603F, 0) == 0x8130U && (d.read(0x1001, 0).value_or(0) & 1U) != 0, "they do not");
    });
    add("the fault stays without a reset", [](DriveClient& d) {
        Result up = enabled(d);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        provoke(d);
        for (const std::uint16_t word : std::array<std::uint16_t, 4>{0x00, 0x06, 0x07, 0x0F}) {
            d.control(word, d.actual());
            if (d.power() != Power::fault) {
                return failed(hex(word) + " leads to " + name_of(d.power()));
            }
        }
        return passed();
    });
    add("the reset is an edge of bit 7", [](DriveClient& d) {
        Result up = enabled(d);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        provoke(d);
        d.control(0x00, d.actual());
        const auto frames = d.control(0x80, d.actual(), 5);
        if (d.power() != Power::disabled) {
            return failed("after the edge it is " + name_of(d.power()));
        }
        const auto codes = d.emergencies(frames);
        return expect(std::ranges::find(codes, 0) != codes.end(), "no EMCY 0000");
    });
    add("a bit 7 that stands resets no later fault", [](DriveClient& d) {
        Result up = enabled(d);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        d.write(0x1016, 1, 4, (0x7FU << 16U) | 50U);
        d.send(0x77F, {5});
        for (int i = 0; i < 200 && d.power() != Power::fault; ++i) {
            d.control(0x8F, d.actual(), 1);
        }
        d.control(0x8F, d.actual(), 5);
        return expect(d.power() == Power::fault, "it is " + name_of(d.power()));
    });
}

void add_csp(std::vector<Case>& list) {
    const auto add = [&list](const char* name, std::function<Result(DriveClient&)> run) {
        list.push_back({.group = "CSP", .name = name, .moves = false, .run = std::move(run)});
    };
    add("6502 has CSP and homing", [](DriveClient& d) {
        const auto modes = d.reset() ? d.read(0x6502, 0) : std::nullopt;
        return expect(modes && (*modes & 0xA0U) == 0xA0U, "6502 is " + hex(modes.value_or(0)));
    });
    add("6061 confirms a mode", [](DriveClient& d) {
        Result up = enabled(d);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        const bool csp = d.read(0x6061, 0) == 8U;
        d.write(0x6060, 0, 1, 6);
        d.control(0x0F, d.actual(), 5);
        return expect(csp && d.read(0x6061, 0) == 6U, "6061 does not show it");
    });
    add("the time between targets can be set", [](DriveClient& d) {
        Result up = enabled(d);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        const auto period = static_cast<std::uint32_t>(d.cycle_ms());
        return expect(d.read(0x60C2, 1) == period && d.read(0x60C2, 2) == 0xFDU, "60C2 reads otherwise");
    });
    add("bit 12 says that it follows", [](DriveClient& d) {
        Result up = enabled(d);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        return expect((d.statusword() & kBit12) != 0, "status word " + hex(d.statusword()));
    });
    add("enabled at its own place it stays there", [](DriveClient& d) {
        Result up = enabled(d);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        const std::int32_t before = d.actual();
        d.control(0x0F, before, 50);
        return expect(std::abs(d.actual() - before) <= 5, "it moves by " + std::to_string(d.actual() - before));
    });
    list.push_back({.group = "CSP", .name = "it follows a ramp", .moves = true, .run = [](DriveClient& d) {
                        Result up = enabled(d);
                        if (up.verdict != Verdict::passed) {
                            return up;
                        }
                        const std::int32_t before = d.actual();
                        for (int i = 1; i <= 100; ++i) {
                            d.control(0x0F, before + 2 * i, 1);
                        }
                        d.control(0x0F, before + 200, 100);
                        const std::int32_t off = d.actual() - before - 200;
                        return expect(std::abs(off) <= 5, "it ends " + std::to_string(off) + " counts off");
                    }});
}

Result home(DriveClient& d, int method) {
    constexpr std::int32_t kHome = 1234;
    Result up = enabled(d);
    if (up.verdict != Verdict::passed) {
        return up;
    }
    if (d.write(0x6098, 0, 1, static_cast<std::uint8_t>(method)) != 0) {
        return left_out("the drive does not have this method");
    }
    const bool set = d.write(0x6099, 1, 4, 50'000) == 0 && d.write(0x6099, 2, 4, 10'000) == 0 &&
                     d.write(0x607C, 0, 4, kHome) == 0 && d.write(0x6060, 0, 1, 6) == 0;
    d.control(0x0F, d.actual(), 5);
    if (!set || d.read(0x6061, 0) != 6U) {
        return failed("homing cannot be set up");
    }
    const auto longest = static_cast<int>(60'000.0 / d.cycle_ms());
    d.control(0x1F, d.actual(), 4);
    for (int i = 0; i < longest; ++i) {
        d.control(0x1F, d.actual(), 1);
        if ((d.statusword() & kBit13) != 0) {
            return failed("homing error, status word " + hex(d.statusword()));
        }
        if ((d.statusword() & kBit12) != 0 && (d.statusword() & kBit10) != 0) {
            const std::int32_t off = d.actual() - kHome;
            return expect(std::abs(off) <= 5, "at its home it reads " + std::to_string(off) + " counts off 607C");
        }
    }
    return failed("it does not end within a minute");
}

void add_homing(std::vector<Case>& list) {
    for (const int method : {37, 35, 33, 34, 19, 20, 21, 22, 17, 18, 1, 2, -1, -2, -3, -4}) {
        list.push_back({.group = "homing",
                        .name = "method " + std::to_string(method),
                        .moves = method != 37 && method != 35,
                        .run = [method](DriveClient& d) { return home(d, method); }});
    }
    list.push_back(
        {.group = "homing", .name = "bit 4 withdrawn breaks it off", .moves = true, .run = [](DriveClient& d) {
             Result up = enabled(d);
             if (up.verdict != Verdict::passed) {
                 return up;
             }
             if (d.write(0x6098, 0, 1, 19) != 0 || d.write(0x6099, 1, 4, 5'000) != 0) {
                 return left_out("the drive does not have method 19");
             }
             d.write(0x6099, 2, 4, 1'000);
             d.write(0x6060, 0, 1, 6);
             d.control(0x0F, d.actual(), 5);
             d.control(0x1F, d.actual(), 20);
             if ((d.statusword() & kBit10) != 0) {
                 return left_out("the axis stands at its home");
             }
             d.control(0x0F, d.actual(), 200);
             const std::int32_t there = d.actual();
             d.control(0x0F, there, 50);
             const bool rests = std::abs(d.actual() - there) <= 1;
             return expect(rests && (d.statusword() & kBit12) == 0, "it goes on");
         }});
}

}  // namespace

std::vector<Case> power_cases() {
    std::vector<Case> list;
    add_states(list);
    add_faults(list);
    add_csp(list);
    add_homing(list);
    return list;
}

std::vector<Case> all_cases() {
    std::vector<Case> list = communication_cases();
    for (Case& one : power_cases()) {
        list.push_back(std::move(one));
    }
    return list;
}

}  // namespace sc::drive_check
