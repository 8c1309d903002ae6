// SPDX-License-Identifier: Apache-2.0
#include "host/cli/pendant_run.hpp"

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "host/bridge/errors.hpp"
#include "host/cli/jog_moves.hpp"
#include "shared/path/item.hpp"

namespace sc::host::cli {
namespace {

constexpr Nanoseconds kShowEvery = std::chrono::milliseconds(100);

std::string amount(Axis axis, double size) {
    return axis == Axis::c ? fmt::format("{:g} deg", size) : fmt::format("{:g} um", 1e6 * size);
}

}  // namespace

PendantRun::PendantRun(CellClient& client, pendant::PendantPort& port, PendantRunOptions options)
    : client_(&client), port_(&port), options_(std::move(options)), control_(options_.control) {}

void PendantRun::note(const std::string& text) const {
    if (options_.on_note) {
        options_.on_note(text);
    }
}

pendant::CellView PendantRun::view() const {
    const auto& status = client_->status();
    return {.moving = client_->state() == State::jogging || !client_->status_is_fresh(),
            .override_percent = status ? status->override_percent : std::uint8_t{100}};
}

bool PendantRun::once() {
    const auto begin = std::chrono::steady_clock::now();
    while (const auto event = port_->next(client_->now())) {
        take(*event);
    }
    carry_out(control_.pass(client_->now(), view()));
    client_->check_fault();
    show();
    const bool over = ended_ || port_->ended();
    if (over && !view().moving) {
        return false;
    }
    client_->pump(client_->now() + options_.look);
    if (port_->real()) {
        // A simulated cell's time must not run ahead of the person's.
        std::this_thread::sleep_until(begin + options_.look);
    }
    return true;
}

void PendantRun::take(const pendant::PortEvent& event) {
    switch (event.kind) {
        case pendant::PortEvent::Kind::plugged:
            control_.plugged();
            shown_.reset();
            note(control_.must_turn() ? "the pendant is there again: turn its axis knob to arm it"
                                      : "the pendant is there");
            break;
        case pendant::PortEvent::Kind::unplugged: carry_out(control_.unplugged(view())); break;
        case pendant::PortEvent::Kind::report:
            carry_out(control_.take(std::span(event.bytes).first(event.size), client_->now(), event.age, view()));
            break;
    }
}

void PendantRun::carry_out(const std::vector<pendant::Wish>& wishes) {
    for (const pendant::Wish& wish : wishes) {
        switch (wish.kind) {
            case pendant::WishKind::jog: jog(wish); break;
            case pendant::WishKind::stop: stop(wish); break;
            case pendant::WishKind::override:
                client_->command(link::Verb::set_override, wish.percent);
                note(fmt::format("feed override {} %", wish.percent));
                break;
            case pendant::WishKind::start_pause:
                note("no job runs here; the host of a job takes a pendant itself: scribe --pendant");
                break;
            case pendant::WishKind::reset: ended_ = true; break;
            case pendant::WishKind::shown: tell_step(); break;
            case pendant::WishKind::take:
            case pendant::WishKind::skip:
            case pendant::WishKind::undo: break;
        }
    }
}

void PendantRun::jog(const pendant::Wish& wish) {
    const bool turn = wish.axis == Axis::c;
    const auto way =
        static_cast<std::int32_t>(std::llround(wish.distance * (turn ? kWireUnitsPerDegree : kWireUnitsPerMetre)));
    jogs_.push_back({client_->now(), wish.axis, wish.distance});
    try {
        client_->command(link::Verb::jog, static_cast<std::int32_t>(index(wish.axis)), way,
                         jog_speed(wish.axis, wish.distance));
    } catch (const CellRefused& no) {
        jogs_.pop_back();
        ++refused_;
        note(no.what());
    }
}

void PendantRun::stop(const pendant::Wish& wish) {
    note(fmt::format("stopped: {}{}", wish.why != nullptr ? wish.why : "",
                     wish.disarmed ? "; turn the axis knob to go on" : ""));
    try {
        client_->command(link::Verb::stop);
    } catch (const CellRefused& no) {
        if (no.refusal != Refusal::wrong_state) {  // it was at rest already
            throw;
        }
    }
}

void PendantRun::tell_step() {
    const auto axis = control_.axis();
    const double step = control_.step();
    std::string text = !axis         ? "the wheel moves nothing"
                       : step <= 0.0 ? fmt::format("{}: no step at this place of the feed knob", "XYZC"[index(*axis)])
                                     : fmt::format("{}: {} a detent", "XYZC"[index(*axis)], amount(*axis, step));
    if (text != told_) {
        note(text);
        told_ = std::move(text);
    }
}

void PendantRun::show() {
    const HostTime now = client_->now();
    if (now < next_show_ || !client_->status() || !control_.connected()) {
        return;
    }
    next_show_ = now + kShowEvery;
    const auto& actual = client_->status()->actual;
    pendant::Display display;
    for (std::size_t i = 0; i < display.lines.size(); ++i) {
        display.lines.at(i) = static_cast<double>(actual.at(i)) / kWireUnitsPerMetre * 1e3;
    }
    display.feed = client_->status()->override_percent;
    const bool turn = control_.axis() == Axis::c;
    display.speed = static_cast<std::uint16_t>(std::lround(control_.step() * (turn ? 1e3 : 1e6)));
    if (display != shown_) {
        shown_ = display;
        port_->show(display);
    }
}

}  // namespace sc::host::cli
