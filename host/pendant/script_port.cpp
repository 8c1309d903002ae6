// SPDX-License-Identifier: Apache-2.0
#include "host/pendant/script_port.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"

namespace sc::host::pendant {
namespace {

using Words = std::vector<std::string>;

constexpr double kLongestMs = 1e7;

const std::map<std::string, AxisKnob, std::less<>>& axes() {
    static const std::map<std::string, AxisKnob, std::less<>> all{
        {"off", AxisKnob::off}, {"x", AxisKnob::x}, {"y", AxisKnob::y}, {"z", AxisKnob::z},
        {"a", AxisKnob::a},     {"b", AxisKnob::b}, {"c", AxisKnob::c}};
    return all;
}

const std::map<std::string, FeedKnob, std::less<>>& feeds() {
    static const std::map<std::string, FeedKnob, std::less<>> all{
        {"0.001", FeedKnob::mm_0_001}, {"0.01", FeedKnob::mm_0_01},   {"0.1", FeedKnob::mm_0_1},
        {"1", FeedKnob::mm_1},         {"60%", FeedKnob::percent_60}, {"100%", FeedKnob::percent_100},
        {"lead", FeedKnob::lead}};
    return all;
}

const std::map<std::string, Key, std::less<>>& keys() {
    static const std::map<std::string, Key, std::less<>> all{{"reset", Key::reset},
                                                             {"stop", Key::stop},
                                                             {"start", Key::start_pause},
                                                             {"feed+", Key::feed_plus},
                                                             {"feed-", Key::feed_minus},
                                                             {"spindle+", Key::spindle_plus},
                                                             {"spindle-", Key::spindle_minus},
                                                             {"m-home", Key::machine_home},
                                                             {"safe-z", Key::safe_z},
                                                             {"w-home", Key::workpiece_home},
                                                             {"s-on", Key::spindle},
                                                             {"fn", Key::fn},
                                                             {"probe-z", Key::probe_z},
                                                             {"mpg", Key::continuous},
                                                             {"step", Key::step},
                                                             {"macro-10", Key::macro_10}};
    return all;
}

/// Turns lines into reports, each with all that is held and turned by then.
class Player {
public:
    /// False: the words are no event.
    bool play(const Words& words, PortEvent& out) {
        const std::string& verb = words[1];
        const std::size_t count = words.size() - 2;
        if (verb == "plug" || verb == "unplug") {
            out.kind = verb == "plug" ? PortEvent::Kind::plugged : PortEvent::Kind::unplugged;
            return count == 0;
        }
        if (verb == "raw") {
            return raw({words.begin() + 2, words.end()}, out);
        }
        report_.detents = 0;
        if (!turn(verb, words, count)) {
            return false;
        }
        random_ = static_cast<std::uint8_t>(random_ * 5 + 77);
        const auto bytes = to_bytes(report_, random_);
        std::ranges::copy(bytes, out.bytes.begin());
        out.size = bytes.size();
        return true;
    }

private:
    bool turn(const std::string& verb, const Words& words, std::size_t count) {
        if (verb == "release") {
            report_.keys = {};
            return count == 0;
        }
        if (verb == "press" && (count == 1 || count == 2)) {
            report_.keys = {};
            for (std::size_t i = 0; i < count; ++i) {
                const auto key = keys().find(words[2 + i]);
                if (key == keys().end()) {
                    return false;
                }
                report_.keys.at(i) = key->second;
            }
            return true;
        }
        if (count != 1) {
            return false;
        }
        if (verb == "axis" && axes().contains(words[2])) {
            report_.axis = axes().at(words[2]);
            return true;
        }
        if (verb == "feed" && feeds().contains(words[2])) {
            report_.feed = feeds().at(words[2]);
            return true;
        }
        double detents = 0.0;
        if (verb == "wheel" && parse_number(words[2], detents) && std::abs(detents) <= 127.0 &&
            detents == std::trunc(detents)) {
            report_.detents = static_cast<int>(detents);
            return true;
        }
        return false;
    }

    static bool raw(const Words& hex, PortEvent& out) {
        if (hex.empty() || hex.size() > out.bytes.size()) {
            return false;
        }
        for (std::size_t i = 0; i < hex.size(); ++i) {
            const std::string& text = hex[i];
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out.bytes.at(i), 16);
            if (error != std::errc{} || end != text.data() + text.size()) {
                return false;
            }
        }
        out.size = hex.size();
        return true;
    }

    Report report_{.keys = {}, .feed = FeedKnob::mm_0_01, .axis = AxisKnob::off, .detents = 0, .proven = true};
    std::uint8_t random_ = 1;
};

}  // namespace

std::vector<ScriptPort::Event> parse_script(const std::string& text, const std::string& name) {
    std::vector<ScriptPort::Event> out;
    Player player;
    std::istringstream lines(text);
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        std::istringstream rest(line.substr(0, line.find('#')));
        Words words;
        for (std::string word; rest >> word;) {
            words.push_back(word);
        }
        if (words.empty()) {
            continue;
        }
        ScriptPort::Event event;
        double ms = 0.0;
        const bool timed = parse_number(words[0], ms) && ms >= 0.0 && ms <= kLongestMs;
        event.at = Nanoseconds(timed ? std::llround(ms * 1e6) : 0);
        const bool later = out.empty() || event.at >= out.back().at;
        if (!timed || !later || words.size() < 2 || !player.play(words, event.event)) {
            throw InputError({.file = name,
                              .line = number,
                              .problem = !timed   ? "does not begin with a time in ms"
                                         : !later ? "comes before the line above it"
                                                  : "is no event of a pendant",
                              .value = shortened(line),
                              .action = "as in: 120 wheel -3 (docs/pendant.md)"});
        }
        out.push_back(event);
    }
    return out;
}

ScriptPort::ScriptPort(const std::filesystem::path& file)
    : events_(parse_script(read_text_file(file), file.string())) {}

std::optional<PortEvent> ScriptPort::next(HostTime now) {
    if (!begun_) {
        begun_ = now;
    }
    if (at_ >= events_.size() || now - *begun_ < events_[at_].at) {
        return std::nullopt;
    }
    return events_[at_++].event;
}

}  // namespace sc::host::pendant
