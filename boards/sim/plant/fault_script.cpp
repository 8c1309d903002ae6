// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/fault_script.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include "boards/sim/world/world_error.hpp"

namespace sc::sim {
namespace {

struct Phrase {
    std::string_view subject;
    std::string_view verb;
    FaultAction action;
};
constexpr std::array kPhrases{Phrase{"estop", "open", FaultAction::estop_open},
                              Phrase{"estop", "close", FaultAction::estop_close},
                              Phrase{"interlock", "open", FaultAction::interlock_open},
                              Phrase{"interlock", "close", FaultAction::interlock_close},
                              Phrase{"laser", "alarm", FaultAction::laser_alarm},
                              Phrase{"laser", "ok", FaultAction::laser_ok},
                              Phrase{"laser", "not_ready", FaultAction::laser_not_ready},
                              Phrase{"laser", "back_reflection", FaultAction::laser_back_reflection},
                              Phrase{"laser", "temperature", FaultAction::laser_temperature},
                              Phrase{"laser", "main_supply", FaultAction::laser_main_supply},
                              Phrase{"laser", "housekeeping", FaultAction::laser_housekeeping},
                              Phrase{"laser", "system", FaultAction::laser_system},
                              Phrase{"laser", "strange", FaultAction::laser_strange},
                              Phrase{"laser", "warning", FaultAction::laser_warning},
                              Phrase{"laser", "starting", FaultAction::laser_starting},
                              Phrase{"laser", "mute", FaultAction::laser_mute},
                              Phrase{"laser", "stubborn", FaultAction::laser_stubborn},
                              Phrase{"laser", "speaks_raycus", FaultAction::laser_speaks_raycus},
                              Phrase{"laser", "speaks_jpt", FaultAction::laser_speaks_jpt},
                              Phrase{"shutter", "stuck", FaultAction::shutter_stuck},
                              Phrase{"shutter", "dropped", FaultAction::shutter_dropped},
                              Phrase{"shutter", "unplugged", FaultAction::shutter_unplugged},
                              Phrase{"shutter", "ok", FaultAction::shutter_ok},
                              Phrase{"key", "off", FaultAction::key_off},
                              Phrase{"key", "setup", FaultAction::key_setup},
                              Phrase{"key", "production", FaultAction::key_production},
                              Phrase{"galvo", "fail", FaultAction::galvo_fail},
                              Phrase{"galvo", "absent", FaultAction::galvo_absent},
                              Phrase{"galvo", "float_high", FaultAction::galvo_float_high},
                              Phrase{"galvo", "float_low", FaultAction::galvo_float_low},
                              Phrase{"galvo", "ok", FaultAction::galvo_ok},
                              Phrase{"drive", "freeze", FaultAction::drive_freeze},
                              Phrase{"drive", "stall", FaultAction::drive_stall},
                              Phrase{"drive", "silent", FaultAction::drive_silent},
                              Phrase{"drive", "fault", FaultAction::drive_fault},
                              Phrase{"drive", "recover", FaultAction::drive_recover},
                              Phrase{"sensor", "silent", FaultAction::sensor_silent},
                              Phrase{"sensor", "crc", FaultAction::sensor_crc},
                              Phrase{"sensor", "wrong_slave", FaultAction::sensor_wrong_slave},
                              Phrase{"sensor", "exception", FaultAction::sensor_exception},
                              Phrase{"sensor", "chopped", FaultAction::sensor_chopped},
                              Phrase{"sensor", "stale", FaultAction::sensor_stale},
                              Phrase{"sensor", "foreign", FaultAction::sensor_foreign},
                              Phrase{"sensor", "blind", FaultAction::sensor_blind},
                              Phrase{"sensor", "slipped", FaultAction::sensor_slipped},
                              Phrase{"sensor", "swapped", FaultAction::sensor_swapped},
                              Phrase{"sensor", "ok", FaultAction::sensor_ok},
                              Phrase{"link", "cut", FaultAction::link_cut},
                              Phrase{"link", "restore", FaultAction::link_restore}};
/// A thousand hours: beyond any script, and far from overflow.
constexpr double kLatestSeconds = 3.6e6;

class LineParser {
public:
    LineParser(const std::string& file, std::size_t line, const std::string& text) : file_(file), line_(line) {
        std::istringstream stream(text);
        words_.assign(std::istream_iterator<std::string>(stream), {});
    }
    [[nodiscard]] bool empty() const { return words_.empty(); }

    FaultEvent parse() {
        FaultEvent event;
        event.line = line_;
        for (const std::string& word : words_) {
            event.text += (event.text.empty() ? "" : " ") + word;
        }
        when(event);
        const std::string subject = take("a subject");
        if (subject == "drive") {
            event.axis = axis();
        } else if (subject == "sensor") {
            event.sensor = sensor();
        }
        const std::string verb = take("what happens to it");
        const auto* const found =
            std::ranges::find_if(kPhrases, [&](const Phrase& p) { return p.subject == subject && p.verb == verb; });
        if (found == kPhrases.end()) {
            refuse(subject + " " + verb, "unknown event", "see the list in boards/sim/README.md");
        }
        event.action = found->action;
        if (event.action == FaultAction::sensor_swapped && event.sensor == kYSensor) {
            refuse("y", "the Y sensor has nobody to change places with", "1, 2 or 3");
        }
        if (event.action == FaultAction::drive_fault) {
            event.error_code = code();
        }
        if (next_ != words_.size()) {
            refuse(words_[next_], "too many words", "one event a line; a comment begins with #");
        }
        return event;
    }

private:
    [[noreturn]] void refuse(const std::string& value, const std::string& problem, const std::string& action) const {
        throw WorldError({file_, line_, value, problem, action});
    }

    std::string take(const std::string& what) {
        if (next_ == words_.size()) {
            refuse(words_.back(), "the line ends where " + what + " is wanted", "write e.g.: at 3.5 estop open");
        }
        return words_[next_++];
    }

    void when(FaultEvent& event) {
        const std::string kind = take("at or pulse");
        if (kind != "at" && kind != "pulse") {
            refuse(kind, "neither at nor pulse", "begin with at SECONDS or pulse NUMBER");
        }
        const std::string word = take("a number");
        if (kind == "at") {
            event.at_ns = seconds(word);
        } else {
            event.after_pulse = count(word);
        }
    }

    [[nodiscard]] std::int64_t seconds(const std::string& word) const {
        double value = 0.0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc{} || end != word.data() + word.size() || !(value >= 0.0) || value > kLatestSeconds) {
            refuse(word, "not a time", "seconds from 0 on, with a decimal point");
        }
        return static_cast<std::int64_t>(std::llround(value * 1e9));
    }

    [[nodiscard]] std::uint64_t count(const std::string& word) const {
        std::uint64_t value = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc{} || end != word.data() + word.size() || value == 0) {
            refuse(word, "not a number of pulses", "a whole number from 1 on");
        }
        return value;
    }

    Axis axis() {
        constexpr std::string_view kLetters = "xyzc";
        const std::string word = take("an axis");
        const std::size_t found = word.size() == 1 ? kLetters.find(word[0]) : std::string_view::npos;
        if (found == std::string_view::npos) {
            refuse(word, "no such axis", "x, y, z or c");
        }
        return static_cast<Axis>(found);
    }

    std::size_t sensor() {
        constexpr std::string_view kNames = "y123";
        const std::string word = take("a sensor");
        const std::size_t found = word.size() == 1 ? kNames.find(word[0]) : std::string_view::npos;
        if (found == std::string_view::npos) {
            refuse(word, "no such sensor", "y, 1, 2 or 3");
        }
        return found;
    }

    std::uint16_t code() {
        const std::string word = take("an error code");
        const bool prefixed = word.starts_with("0x") || word.starts_with("0X");
        const char* const begin = word.data() + (prefixed ? 2 : 0);
        std::uint16_t value = 0;
        const auto [end, error] = std::from_chars(begin, word.data() + word.size(), value, prefixed ? 16 : 10);
        if (error != std::errc{} || end != word.data() + word.size() || value == 0) {
            refuse(word, "not an error code", "16 bits, not 0, e.g. 0x2310");
        }
        return value;
    }

    const std::string& file_;
    std::size_t line_;
    std::vector<std::string> words_;
    std::size_t next_ = 0;
};

}  // namespace

std::vector<FaultEvent> parse_fault_script(std::string_view text, const std::string& file) {
    std::vector<FaultEvent> events;
    std::istringstream stream{std::string(text)};
    std::string line;
    for (std::size_t number = 1; std::getline(stream, line); ++number) {
        LineParser parser(file, number, line.substr(0, line.find('#')));
        if (!parser.empty()) {
            events.push_back(parser.parse());
        }
    }
    std::ranges::sort(events, {}, [](const FaultEvent& e) { return std::pair(e.at_ns.value_or(0), e.line); });
    return events;
}

std::vector<FaultEvent> read_fault_script(const std::filesystem::path& file) {
    const std::ifstream stream(file);
    if (!stream) {
        throw WorldError({file.string(), 0, "", "cannot be read", "give the path of a fault script"});
    }
    std::ostringstream text;
    text << stream.rdbuf();
    return parse_fault_script(text.str(), file.string());
}

}  // namespace sc::sim
