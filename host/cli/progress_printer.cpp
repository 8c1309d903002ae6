// SPDX-License-Identifier: Apache-2.0
#include "host/cli/progress_printer.hpp"

#include <algorithm>
#include <cstdio>

#include <unistd.h>

namespace sc::host::cli {
namespace {

constexpr int kBarWidth = 30;

}  // namespace

bool stderr_is_terminal() { return ::isatty(STDERR_FILENO) == 1; }

std::string clock_text(Nanoseconds time) {
    const std::int64_t seconds = (std::max<std::int64_t>(time.count(), 0) + 999'999'999) / 1'000'000'000;
    std::string text(32, '\0');
    const std::int64_t hours = seconds / 3600;
    int size = 0;
    if (hours > 0) {
        size = std::snprintf(text.data(), text.size(), "%lld:%02d:%02d", static_cast<long long>(hours),
                             static_cast<int>(seconds / 60 % 60), static_cast<int>(seconds % 60));
    } else {
        size = std::snprintf(text.data(), text.size(), "%d:%02d", static_cast<int>(seconds / 60),
                             static_cast<int>(seconds % 60));
    }
    text.resize(static_cast<std::size_t>(size));
    return text;
}

void ProgressPrinter::show(const Progress& progress) {
    const int percent = static_cast<int>(progress.fraction * 100.0);
    const std::string left = progress.left ? clock_text(*progress.left) + " left" : std::string("time left unknown");
    if (terminal_) {
        const int full = percent * kBarWidth / 100;
        std::string bar(static_cast<std::size_t>(full), '#');
        bar.resize(kBarWidth, '.');
        std::fprintf(stderr, "\r[%s] %3d %%  %s   ", bar.c_str(), percent, left.c_str());
        std::fflush(stderr);
        bar_open_ = true;
        return;
    }
    const int tenths = percent / 10;
    if (tenths > tenths_shown_) {
        tenths_shown_ = tenths;
        std::fprintf(stderr, "%3d %%, %u of %u items fired, %s\n", tenths * 10, progress.fired, progress.items,
                     left.c_str());
    }
}

void ProgressPrinter::step(const std::string& what) {
    end_line();
    std::fprintf(stderr, "%s\n", what.c_str());
}

void ProgressPrinter::end_line() {
    if (bar_open_) {
        std::fprintf(stderr, "\n");
        bar_open_ = false;
    }
}

}  // namespace sc::host::cli
