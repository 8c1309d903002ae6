// SPDX-License-Identifier: Apache-2.0
#include "host/cli/job_pendant.hpp"

#include <span>
#include <utility>

namespace sc::host::cli {

JobPendant::JobPendant(const PendantWords& words, std::function<void(const std::string&)> on_note)
    : port_(open_pendant(words)), on_note_(std::move(on_note)) {}

void JobPendant::look(HostTime now, std::uint8_t override_percent) {
    while (const auto event = port_->next(now)) {
        // To the control the axes move all along: so the wheel counts for nothing.
        const pendant::CellView cell{.moving = true, .override_percent = override_.value_or(override_percent)};
        if (event->kind == pendant::PortEvent::Kind::plugged) {
            control_.plugged();
            continue;
        }
        if (event->kind == pendant::PortEvent::Kind::unplugged) {
            (void)control_.unplugged(cell);
            on_note_("the pendant is unplugged; the job goes on");
            continue;
        }
        for (const pendant::Wish& wish :
             control_.take(std::span(event->bytes).first(event->size), now, event->age, cell)) {
            if (wish.kind == pendant::WishKind::override) {
                override_ = wish.percent;
            } else if (wish.kind == pendant::WishKind::start_pause) {
                pause_ = !pause_;
                paused_ = !paused_;
                on_note_(paused_ ? "paused by the pendant" : "the pendant lets it go on");
            } else if (wish.kind == pendant::WishKind::stop && wish.disarmed) {
                stopped_ = true;  // of a report, the key alone disarms
            }
        }
    }
}

std::optional<std::uint8_t> JobPendant::take_override() { return std::exchange(override_, std::nullopt); }

bool JobPendant::take_pause() { return std::exchange(pause_, false); }

}  // namespace sc::host::cli
