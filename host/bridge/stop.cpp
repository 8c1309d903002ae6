// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/stop.hpp"

#include <initializer_list>

#include <signal.h>

namespace sc::host {
namespace {

volatile sig_atomic_t stop_flag = 0;

extern "C" void note_stop_signal(int /*signal*/) { stop_flag = 1; }

}  // namespace

void install_stop_signals() {
    struct sigaction action{};
    action.sa_handler = note_stop_signal;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigemptyset(&action.sa_mask);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        sigaction(signal, &action, nullptr);
    }
    ::signal(SIGPIPE, SIG_IGN);
}

bool stop_requested() noexcept { return stop_flag != 0; }

}  // namespace sc::host
