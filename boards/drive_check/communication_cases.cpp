// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>

#include "boards/drive_check/cases.hpp"

namespace sc::drive_check {
namespace {

constexpr std::uint8_t kStart = 0x01;
constexpr std::uint8_t kStop = 0x02;
constexpr std::uint8_t kPreOperational = 0x80;
constexpr std::uint8_t kResetCommunication = 0x82;
constexpr std::uint32_t kOff = 0x8000'0000;
constexpr std::uint32_t kNoRemoteRequest = 0x4000'0000;

/// The state in the drive's last heartbeat among these; −1 without one.
int heartbeat(const DriveClient& drive, const std::vector<Frame>& frames) {
    int state = -1;
    for (const Frame& frame : frames) {
        if (frame.id == 0x700U + drive.node() && frame.data.size() == 1) {
            state = frame.data[0] & 0x7F;
        }
    }
    return state;
}

Result state_after(DriveClient& drive, std::uint8_t command, int node, int wanted) {
    if (!drive.reset() || drive.write(0x1017, 0, 2, 20) != 0) {
        return failed("no boot-up message, or 1017 cannot be written");
    }
    drive.nmt(command, node);
    const int state = heartbeat(drive, drive.run_ms(100.0));
    return expect(state == wanted, "heartbeat says " + std::to_string(state) + ", not " + std::to_string(wanted));
}

Result aborts(DriveClient& drive, const std::vector<std::uint8_t>& request, const std::vector<std::uint32_t>& codes) {
    if (!drive.reset()) {
        return failed("no boot-up message");
    }
    const auto reply = drive.ask(request);
    if (reply.empty() || reply[0] != 0x80) {
        return failed(reply.empty() ? "no answer" : "no abort but " + hex(reply[0]));
    }
    const std::uint32_t code = reply[4] | (std::uint32_t{reply[5]} << 8U) | (std::uint32_t{reply[6]} << 16U) |
                               (std::uint32_t{reply[7]} << 24U);
    for (const std::uint32_t one : codes) {
        if (code == one) {
            return passed();
        }
    }
    return failed("aborts with " + hex(code) + ", not " + hex(codes.front()));
}

struct Upload {
    std::string text;
    std::string trouble;
    std::size_t announced = 0;
    int segments = 0;
};
Upload upload(DriveClient& drive, std::uint16_t index) {
    Upload result;
    const auto lo = static_cast<std::uint8_t>(index);
    const auto hi = static_cast<std::uint8_t>(index >> 8U);
    auto reply = drive.ask({0x40, lo, hi, 0});
    if (reply.empty() || reply[0] == 0x80) {
        result.trouble = "no such object";
        return result;
    }
    if ((reply[0] & 2U) != 0) {
        result.text.assign(reply.begin() + 4, reply.end() - ((reply[0] >> 2U) & 3U));
        return result;
    }
    result.announced = (reply[0] & 1U) != 0 ? reply[4] | (std::size_t{reply[5]} << 8U) : 0;
    for (std::uint8_t toggle = 0; result.segments < 200; toggle ^= 0x10U) {
        reply = drive.ask({static_cast<std::uint8_t>(0x60U | toggle)});
        ++result.segments;
        if (reply.empty() || (reply[0] & 0xE0U) != 0 || (reply[0] & 0x10U) != toggle) {
            result.trouble = reply.empty() ? "a segment stays unanswered" : "segment answered by " + hex(reply[0]);
            return result;
        }
        const unsigned unused = (reply[0] >> 1U) & 7U;
        result.text.append(reply.begin() + 1, reply.end() - static_cast<std::ptrdiff_t>(unused));
        if ((reply[0] & 1U) != 0) {
            return result;
        }
    }
    result.trouble = "does not end";
    return result;
}

void add_nmt(std::vector<Case>& list) {
    const auto add = [&list](const char* name, std::function<Result(DriveClient&)> run) {
        list.push_back({.group = "NMT", .name = name, .moves = false, .run = std::move(run)});
    };
    add("boot-up message after a reset of the node",
        [](DriveClient& d) { return expect(d.reset(), "no boot-up message"); });
    add("boot-up message after a reset of the communication", [](DriveClient& d) {
        if (!d.reset()) {
            return failed("no boot-up message");
        }
        d.nmt(kResetCommunication);
        int boots = 0;
        for (const Frame& frame : d.run_ms(500.0)) {
            boots += frame.id == 0x700U + d.node() && frame.data == std::vector<std::uint8_t>{0} ? 1 : 0;
        }
        return expect(boots == 1, std::to_string(boots) + " boot-up messages");
    });
    add("pre-operational by itself", [](DriveClient& d) { return state_after(d, 0, 126, 0x7F); });
    add("start", [](DriveClient& d) { return state_after(d, kStart, -1, 0x05); });
    add("stop", [](DriveClient& d) { return state_after(d, kStop, -1, 0x04); });
    add("pre-operational by command", [](DriveClient& d) {
        Result started = state_after(d, kStart, -1, 0x05);
        if (started.verdict != Verdict::passed) {
            return started;
        }
        d.nmt(kPreOperational);
        return expect(heartbeat(d, d.run_ms(100.0)) == 0x7F, "stays operational");
    });
    add("start of all nodes", [](DriveClient& d) { return state_after(d, kStart, 0, 0x05); });
    add("commands to another node do nothing",
        [](DriveClient& d) { return state_after(d, kStart, d.node() == 100 ? 101 : 100, 0x7F); });
    add("stopped, it answers no SDO", [](DriveClient& d) {
        if (!d.reset()) {
            return failed("no boot-up message");
        }
        d.nmt(kStop);
        d.run(2);
        return expect(d.ask({0x40, 0x00, 0x10, 0}).empty(), "it answers");
    });
}

void add_heartbeat(std::vector<Case>& list) {
    const auto add = [&list](const char* name, std::function<Result(DriveClient&)> run) {
        list.push_back({.group = "heartbeat", .name = name, .moves = false, .run = std::move(run)});
    };
    add("comes as often as 1017 says", [](DriveClient& d) {
        if (!d.reset() || d.write(0x1017, 0, 2, 40) != 0) {
            return failed("1017 cannot be written");
        }
        d.run_ms(80.0);
        const int count = d.count(d.run_ms(800.0), 0x700U + d.node());
        return expect(count >= 18 && count <= 22, std::to_string(count) + " in 800 ms, not 20");
    });
    add("stays away with 1017 = 0", [](DriveClient& d) {
        if (!d.reset() || d.write(0x1017, 0, 2, 0) != 0) {
            return failed("1017 cannot be written");
        }
        d.run(2);
        return expect(d.count(d.run_ms(200.0), 0x700U + d.node()) == 0, "it comes");
    });
}

void add_sdo(std::vector<Case>& list) {
    const auto add = [&list](const char* name, std::function<Result(DriveClient&)> run) {
        list.push_back({.group = "SDO", .name = name, .moves = false, .run = std::move(run)});
    };
    add("reads of 1, 2 and 4 bytes say their size", [](DriveClient& d) {
        if (!d.reset()) {
            return failed("no boot-up message");
        }
        const auto four = d.ask({0x40, 0x00, 0x10, 0});
        const auto two = d.ask({0x40, 0x41, 0x60, 0});
        const auto one = d.ask({0x40, 0x61, 0x60, 0});
        return expect(
            !four.empty() && four[0] == 0x43 && !two.empty() && two[0] == 0x4B && !one.empty() && one[0] == 0x4F,
            "a wrong command byte");
    });
    add("device type 1000 says CiA 402", [](DriveClient& d) {
        const auto type = d.reset() ? d.read(0x1000, 0) : std::nullopt;
        return expect(type && (*type & 0xFFFFU) == 402, "it does not");
    });
    add("what is written is read back", [](DriveClient& d) {
        const bool written = d.reset() && d.write(0x607C, 0, 4, 0xFFFF'FF85) == 0;
        return expect(written && d.read(0x607C, 0) == 0xFFFF'FF85U, "607C does not");
    });
    add("a write of the wrong length is refused",
        [](DriveClient& d) { return aborts(d, {0x2F, 0x7C, 0x60, 0, 1}, {0x0607'0010, 0x0607'0012, 0x0607'0013}); });
    add("an object that is not there is refused",
        [](DriveClient& d) { return aborts(d, {0x40, 0xFF, 0x5F, 0}, {0x0602'0000}); });
    add("a part that is not there is refused",
        [](DriveClient& d) { return aborts(d, {0x40, 0x18, 0x10, 99}, {0x0609'0011}); });
    add("a write to what is read only is refused",
        [](DriveClient& d) { return aborts(d, {0x2B, 0x41, 0x60, 0, 1, 0}, {0x0601'0002}); });
    add("a mode that is none is refused",
        [](DriveClient& d) { return aborts(d, {0x2F, 0x60, 0x60, 0, 99}, {0x0609'0030, 0x0609'0031, 0x0800'0022}); });
    add("a command that is none is refused",
        [](DriveClient& d) { return aborts(d, {0xE0, 0x00, 0x10, 0}, {0x0504'0001}); });
    add("requests to another node stay unanswered", [](DriveClient& d) {
        if (!d.reset()) {
            return failed("no boot-up message");
        }
        d.send(0x600U + (d.node() == 100 ? 101U : 100U), {0x40, 0, 0x10, 0, 0, 0, 0, 0});
        return expect(d.count(d.run(2), 0x580U + d.node()) == 0, "it answers");
    });
}

void add_segmented(std::vector<Case>& list) {
    const auto add = [&list](const char* name, std::function<Result(DriveClient&)> run) {
        list.push_back({.group = "SDO segmented", .name = name, .moves = false, .run = std::move(run)});
    };
    add("the device's name 1008 is read in segments", [](DriveClient& d) {
        if (!d.reset()) {
            return failed("no boot-up message");
        }
        const Upload name = upload(d, 0x1008);
        if (!name.trouble.empty()) {
            return name.trouble == "no such object" ? left_out(name.trouble) : failed(name.trouble);
        }
        if (name.segments == 0) {
            return left_out("the name has four letters or fewer");
        }
        return expect(
            !name.text.empty() && (name.announced == 0 || name.announced == name.text.size()),
            "announces " + std::to_string(name.announced) + " bytes and sends " + std::to_string(name.text.size()));
    });
    add("a wrong toggle bit is refused", [](DriveClient& d) {
        if (!d.reset()) {
            return failed("no boot-up message");
        }
        const auto begin = d.ask({0x40, 0x08, 0x10, 0});
        if (begin.empty() || (begin[0] & 2U) != 0 || begin[0] == 0x80) {
            return left_out("1008 is not segmented");
        }
        const auto reply = d.ask({0x70});
        return expect(!reply.empty() && reply[0] == 0x80 && reply[6] == 0x03 && reply[7] == 0x05, "it is taken");
    });
    add("a segment without a beginning is refused", [](DriveClient& d) {
        if (!d.reset()) {
            return failed("no boot-up message");
        }
        const auto reply = d.ask({0x60});
        return expect(!reply.empty() && reply[0] == 0x80, "no abort");
    });
    add("an abort ends a transfer", [](DriveClient& d) {
        if (!d.reset() || d.ask({0x40, 0x08, 0x10, 0}).empty()) {
            return failed("no answer");
        }
        d.send(0x600U + d.node(), {0x80, 0x08, 0x10, 0, 0, 0, 0x04, 0x05});
        d.run(1);
        const auto reply = d.ask({0x60});
        return expect(!reply.empty() && reply[0] == 0x80, "the transfer goes on");
    });
    add("a text is written in segments", [](DriveClient& d) {
        if (!d.reset()) {
            return failed("no boot-up message");
        }
        const auto begin = d.ask({0x21, 0x00, 0x20, 0, 10, 0, 0, 0});
        if (begin.empty() || begin[0] == 0x80) {
            return left_out("no text object 2000");
        }
        const auto first = d.ask({0x00, 'v', 'e', 'r', 't', 'i', 'c', 'a'});
        const auto last = d.ask({0x19, 'l', ' ', 'z'});
        const bool taken = !first.empty() && first[0] == 0x20 && !last.empty() && last[0] == 0x30;
        return expect(taken && upload(d, 0x2000).text == "vertical z", "what was written is not there");
    });
}

Result set_up(DriveClient& d, std::uint8_t every) {
    return expect(d.operational(every), "the set-up is refused (abort " + hex(d.abort_code()) + ")");
}

void add_pdo(std::vector<Case>& list) {
    const auto add = [&list](const char* name, std::function<Result(DriveClient&)> run) {
        list.push_back({.group = "PDO", .name = name, .moves = false, .run = std::move(run)});
    };
    add("can be mapped and tied to SYNC", [](DriveClient& d) { return set_up(d, 1); });
    add("none before start",
        [](DriveClient& d) { return expect(d.reset() && d.count(d.run(5), 0x180U + d.node()) == 0, "a TPDO comes"); });
    add("a status with each SYNC", [](DriveClient& d) {
        Result up = set_up(d, 1);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        const int count = d.count(d.run(50), 0x180U + d.node());
        return expect(count >= 49 && count <= 51, std::to_string(count) + " to 50 SYNCs");
    });
    add("a status with each 2nd and 3rd SYNC", [](DriveClient& d) {
        for (const int every : {2, 3}) {
            Result up = set_up(d, static_cast<std::uint8_t>(every));
            if (up.verdict != Verdict::passed) {
                return up;
            }
            const int count = d.count(d.run(60), 0x180U + d.node());
            if (std::abs(count - 60 / every) > 1) {
                return failed(std::to_string(count) + " to 60 SYNCs, not " + std::to_string(60 / every));
            }
        }
        return passed();
    });
    add("none from one that is off", [](DriveClient& d) {
        Result up = set_up(d, 1);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        d.nmt(kPreOperational);
        const bool off = d.write(0x1800, 1, 4, (0x180U + d.node()) | kNoRemoteRequest | kOff) == 0;
        d.nmt(kStart);
        d.run(1);
        return expect(off && d.count(d.run(5), 0x180U + d.node()) == 0, "it comes");
    });
    add("a target counts from the SYNC on, not before", [](DriveClient& d) {
        Result up = set_up(d, 1);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        d.send(0x200U + d.node(), {0x06, 0, 0, 0, 0, 0});
        const auto before = d.read(0x6041, 0);
        d.run(2);
        const auto after = d.read(0x6041, 0);
        const bool right = before && after && power_of(static_cast<std::uint16_t>(*before)) == Power::disabled &&
                           power_of(static_cast<std::uint16_t>(*after)) == Power::ready;
        return expect(right,
                      "before the SYNC " + (before ? hex(*before) : "-") + ", after " + (after ? hex(*after) : "-"));
    });
    add("a mapping cannot change while the PDO is on", [](DriveClient& d) {
        Result up = set_up(d, 1);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        d.nmt(kPreOperational);
        d.run(1);
        return expect(d.write(0x1A00, 1, 4, 0x6041'0010) != 0, "it changes");
    });
    add("what cannot be mapped is refused", [](DriveClient& d) {
        const bool open = d.reset() && d.write(0x1800, 1, 4, (0x180U + d.node()) | kNoRemoteRequest | kOff) == 0 &&
                          d.write(0x1A00, 0, 1, 0) == 0;
        return expect(open && d.write(0x1A00, 1, 4, 0x5FFF'0020) != 0, "it is mapped");
    });
    add("more than eight bytes are refused", [](DriveClient& d) {
        bool open = d.reset() && d.write(0x1800, 1, 4, (0x180U + d.node()) | kNoRemoteRequest | kOff) == 0 &&
                    d.write(0x1A00, 0, 1, 0) == 0;
        for (std::uint8_t sub = 1; sub <= 3; ++sub) {
            open = open && d.write(0x1A00, sub, 4, 0x6064'0020) == 0;
        }
        return expect(!open || d.write(0x1A00, 0, 1, 3) != 0, "they are mapped");
    });
    add("places of an RPDO can be skipped (0007)", [](DriveClient& d) {
        Result up = set_up(d, 1);
        if (up.verdict != Verdict::passed) {
            return up;
        }
        d.nmt(kPreOperational);
        const std::uint32_t rpdo = 0x200U + d.node();
        const bool mapped = d.write(0x1400, 1, 4, rpdo | kOff) == 0 && d.write(0x1600, 0, 1, 0) == 0;
        if (!mapped || d.write(0x1600, 1, 4, 0x0007'0020) != 0) {
            return left_out("the drive has no dummy mapping");
        }
        const bool second = d.write(0x1600, 2, 4, 0x607A'0020) == 0 && d.write(0x1600, 0, 1, 2) == 0 &&
                            d.write(0x1400, 1, 4, rpdo) == 0;
        d.nmt(kStart);
        d.send(rpdo, {1, 2, 3, 4, 0x78, 0x56, 0x34, 0x12});
        d.run(2);
        return expect(second && d.read(0x607A, 0) == 0x1234'5678U, "607A is " + hex(d.read(0x607A, 0).value_or(0)));
    });
}

}  // namespace

std::string hex(std::uint32_t value) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), "%08X", value);
    return text.data();
}

std::vector<Case> communication_cases() {
    std::vector<Case> list;
    add_nmt(list);
    add_heartbeat(list);
    add_sdo(list);
    add_segmented(list);
    add_pdo(list);
    return list;
}

}  // namespace sc::drive_check
