// SPDX-License-Identifier: Apache-2.0
#include "host/cli/override_keys.hpp"

#include <algorithm>

#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "shared/link/messages.hpp"

namespace sc::host::cli {
namespace {

constexpr int kStep = 10;

}  // namespace

std::optional<std::uint8_t> override_after(char key, std::uint8_t percent) {
    const auto within = [](int value) {
        return static_cast<std::uint8_t>(std::clamp<int>(value, link::kMinOverride, link::kMaxOverride));
    };
    switch (key) {
        case '+':
        case '=': return within(percent + kStep);
        case '-': return within(percent - kStep);
        case '0': return std::uint8_t{100};
        default: return std::nullopt;
    }
}

struct TerminalKeys::Terminal {
    termios settings;
};

TerminalKeys::TerminalKeys() {
    // A program in the background would be stopped by touching the terminal.
    if (::isatty(STDIN_FILENO) != 1 || ::tcgetpgrp(STDIN_FILENO) != ::getpgrp()) {
        return;
    }
    auto before = std::make_unique<Terminal>();
    if (::tcgetattr(STDIN_FILENO, &before->settings) != 0) {
        return;
    }
    termios now = before->settings;
    now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    if (::tcsetattr(STDIN_FILENO, TCSANOW, &now) == 0) {
        before_ = std::move(before);
    }
}

TerminalKeys::~TerminalKeys() {
    if (before_) {
        ::tcsetattr(STDIN_FILENO, TCSANOW, &before_->settings);
    }
}

std::optional<char> TerminalKeys::next() {
    pollfd ready{STDIN_FILENO, POLLIN, 0};
    if (!before_ || ::poll(&ready, 1, 0) <= 0 || (ready.revents & POLLIN) == 0) {
        return std::nullopt;
    }
    char key = 0;
    return ::read(STDIN_FILENO, &key, 1) == 1 ? std::optional(key) : std::nullopt;
}

}  // namespace sc::host::cli
