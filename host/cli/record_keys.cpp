// SPDX-License-Identifier: Apache-2.0
#include "host/cli/record_keys.hpp"

#include <cmath>
#include <cstdio>
#include <sstream>

#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "host/formats/text.hpp"

namespace sc::host::cli {
namespace {

constexpr double kFinest = 1e-6;
constexpr double kCoarsest = 1e-2;
constexpr int kMostRepeats = 10'000;

RecordKey jog(Axis axis, int sign) { return {.action = RecordAction::jog, .axis = axis, .sign = sign}; }
RecordKey of(RecordAction action) { return {.action = action}; }
RecordKey step(double metres) { return {.action = RecordAction::step, .axis = Axis::x, .sign = 1, .step = metres}; }

std::optional<RecordKey> of_letter(char key) {
    switch (key) {
        case 'a': return jog(Axis::x, 1);  // to the left, seen from the laser
        case 'd': return jog(Axis::x, -1);
        case 'w': return jog(Axis::z, 1);
        case 's': return jog(Axis::z, -1);
        case 'r': return jog(Axis::y, 1);
        case 'f': return jog(Axis::y, -1);
        case '1': return step(1e-3);
        case '2': return step(1e-4);
        case '3': return step(1e-5);
        case '4': return step(1e-6);
        case '\n':
        case '\r': return of(RecordAction::record);
        case 'n': return of(RecordAction::skip);
        case 'u': return of(RecordAction::undo);
        case 'q': return of(RecordAction::quit);
        case '?': return of(RecordAction::help);
        default: return std::nullopt;
    }
}

std::optional<RecordKey> of_word(const std::string& word) {
    if (word.size() == 2 && (word[1] == '+' || word[1] == '-')) {
        const std::size_t axis = std::string("xyz").find(word[0]);
        if (axis != std::string::npos) {
            return jog(static_cast<Axis>(axis), word[1] == '+' ? 1 : -1);
        }
    }
    if (double mm = 0.0; word.starts_with("step=") && parse_number(word.substr(5), mm)) {
        const double metres = 1e-3 * mm;
        return metres >= kFinest && metres <= kCoarsest ? std::optional(step(metres)) : std::nullopt;
    }
    if (word == "enter") {
        return of(RecordAction::record);
    }
    if (word == "skip") {
        return of(RecordAction::skip);
    }
    if (word == "undo") {
        return of(RecordAction::undo);
    }
    return word == "quit" ? std::optional(of(RecordAction::quit)) : std::nullopt;
}

}  // namespace

std::optional<RecordKey> KeyboardInput::next() {
    const auto key = keys_.next();
    if (!key) {
        return std::nullopt;
    }
    if (*key != '\x1b') {
        return of_letter(*key);
    }
    // An arrow is ESC [ A..D, all of it there at once.
    if (keys_.next() != '[') {
        return std::nullopt;
    }
    switch (keys_.next().value_or('\0')) {
        case 'A': return jog(Axis::z, 1);
        case 'B': return jog(Axis::z, -1);
        case 'C': return jog(Axis::x, -1);
        case 'D': return jog(Axis::x, 1);
        default: return std::nullopt;
    }
}

ScriptInput::ScriptInput(const std::filesystem::path& file) {
    std::istringstream text(read_text_file(file));
    int number = 0;
    for (std::string line; std::getline(text, line);) {
        ++number;
        std::istringstream words(line.substr(0, line.find('#')));
        for (std::string word; words >> word;) {
            double times = 1.0;
            const std::size_t star = word.find('*');
            const bool counted = star == std::string::npos || parse_number(word.substr(star + 1), times);
            const auto key = of_word(word.substr(0, star));
            if (!key || !counted || !(times >= 1.0 && times <= kMostRepeats)) {
                throw InputError({.file = file.string(),
                                  .line = number,
                                  .problem = "is no key",
                                  .value = shortened(word),
                                  .action = "use x+ x- y+ y- z+ z- (x+*5), step=0.01, enter, skip, undo, quit"});
            }
            keys_.insert(keys_.end(), static_cast<std::size_t>(times), *key);
        }
    }
}

bool PendantInput::look(bool moving) {
    bool stop = false;
    const auto carry_out = [&](const std::vector<pendant::Wish>& wishes) {
        for (const pendant::Wish& wish : wishes) {
            switch (wish.kind) {
                case pendant::WishKind::jog:
                    // The table is turned by the procedure, not by hand.
                    if (wish.axis != Axis::c) {
                        RecordKey key = jog(wish.axis, wish.distance > 0.0 ? 1 : -1);
                        key.step = std::abs(wish.distance);
                        keys_.push_back(key);
                    }
                    break;
                case pendant::WishKind::stop:
                    stop = true;
                    keys_.clear();
                    std::fprintf(stderr, "stopped: %s\n", wish.why != nullptr ? wish.why : "");
                    break;
                case pendant::WishKind::take: keys_.push_back(of(RecordAction::record)); break;
                case pendant::WishKind::skip: keys_.push_back(of(RecordAction::skip)); break;
                case pendant::WishKind::undo: keys_.push_back(of(RecordAction::undo)); break;
                case pendant::WishKind::reset: keys_.push_back(of(RecordAction::quit)); break;
                case pendant::WishKind::shown:
                    if (const auto axis = control_.axis()) {
                        std::fprintf(stderr, "pendant: %c, %g um a detent\n", "XYZC"[index(*axis)],
                                     1e6 * control_.step());
                    }
                    break;
                case pendant::WishKind::override:
                case pendant::WishKind::start_pause: break;
            }
        }
    };
    const pendant::CellView view{.moving = moving};
    while (const auto event = port_->next(now_())) {
        switch (event->kind) {
            case pendant::PortEvent::Kind::plugged: control_.plugged(); break;
            case pendant::PortEvent::Kind::unplugged: carry_out(control_.unplugged(view)); break;
            case pendant::PortEvent::Kind::report:
                carry_out(control_.take(std::span(event->bytes).first(event->size), now_(), event->age,
                                        {.moving = moving || !keys_.empty()}));
                break;
        }
    }
    carry_out(control_.pass(now_(), view));
    return stop;
}

std::optional<RecordKey> PendantInput::next() {
    look(false);
    if (keys_.empty()) {
        return std::nullopt;
    }
    const RecordKey first = keys_.front();
    keys_.pop_front();
    return first;
}

bool PendantInput::stops() {
    const bool stop = look(true);
    keys_.clear();
    return stop;
}

void PendantInput::show(const std::array<double, 3>& place_mm) {
    pendant::Display display;
    display.lines = place_mm;
    display.feed = 100;
    display.speed = static_cast<std::uint16_t>(std::lround(1e6 * control_.step()));
    port_->show(display);
}

std::unique_ptr<RecordInput> pendant_input(const PendantWords& words, std::unique_ptr<pendant::PendantPort>& port,
                                           std::function<HostTime()> now) {
    port = open_pendant(words);
    auto input = std::make_unique<PendantInput>(*port, std::move(now));
    auto keyboard = std::make_unique<KeyboardInput>();
    if (keyboard->ended()) {
        return input;
    }
    return std::make_unique<BothInputs>(std::move(input), std::move(keyboard));
}

std::optional<RecordKey> ScriptInput::next() { return at_ < keys_.size() ? std::optional(keys_[at_++]) : std::nullopt; }

}  // namespace sc::host::cli
