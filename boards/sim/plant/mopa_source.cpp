// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/plant/mopa_source.hpp"

#include <algorithm>
#include <cstdio>
#include <set>
#include <utility>

namespace sc::sim {
namespace {

constexpr int kAnswerTicks = 2;
const std::set<unsigned>& jpt_widths() {
    static const std::set<unsigned> kWidths{2, 4, 6, 9, 13, 20, 30, 45, 60, 80, 100, 150, 200, 250, 350};
    return kWidths;
}

}  // namespace

void MopaSource::receive(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) {
        if (maker_ == LaserSource::raycus) {
            hear_raycus(byte);
        } else if (maker_ == LaserSource::jpt) {
            hear_jpt(byte);
        }
    }
}

void MopaSource::take(std::vector<std::uint8_t>& out) {
    if (answer_in_ == 0) {
        return;
    }
    --answer_in_;
    if (answer_in_ == 0) {
        out.insert(out.end(), answer_.begin(), answer_.end());
    }
}

void MopaSource::answer(std::vector<std::uint8_t> bytes) {
    if (!mute_) {
        answer_ = std::move(bytes);
        answer_in_ = kAnswerTicks;
    }
}

bool MopaSource::change(unsigned width_ns) {
    const bool known = maker_ == LaserSource::jpt ? jpt_widths().contains(width_ns) : width_ns >= 2 && width_ns <= 500;
    if (!known || emits_) {
        return false;
    }
    width_ns_ = stays_ ? width_ns_ : width_ns;
    return true;
}

void MopaSource::hear_raycus(std::uint8_t byte) {
    if (frame_.empty() && byte != 0xA5) {
        return;
    }
    frame_.push_back(byte);
    if (frame_.size() == 4) {
        const bool asks_width = frame_[1] == 0x01;
        if (asks_width) {
            // A width that it does not know it leaves, and tells the one in force.
            (void)change(frame_[2] * 256U + frame_[3]);
            answer({0xA5, static_cast<std::uint8_t>(width_ns_ / 256U), static_cast<std::uint8_t>(width_ns_ % 256U)});
        }
        frame_.clear();
    }
}

void MopaSource::hear_jpt(std::uint8_t byte) {
    if (line_.empty() && byte != '$') {
        answer({'E'});
        return;
    }
    line_.push_back(static_cast<char>(byte));
    if (byte != '*' && line_.size() < 16) {
        return;
    }
    unsigned width = 0;
    char end = 0;
    const bool right = line_.size() == 8 && std::sscanf(line_.c_str(), "$34;%3u%c", &width, &end) == 2 && end == '*';
    if (right && change(width)) {
        char text[9] = {};
        (void)std::snprintf(text, sizeof(text), "$34;%03u*", width_ns_ % 1000U);
        answer(std::vector<std::uint8_t>(text, text + 8));
    } else {
        answer({'E'});
    }
    line_.clear();
}

}  // namespace sc::sim
