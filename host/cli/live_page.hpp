// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "host/bridge/unique_fd.hpp"

namespace sc::host::cli {

/// A page on the loopback interface that shows one picture and refreshes it twice a second. Served from the caller's
/// own thread by poll(): no thread, no lock. It answers GET of / (the page) and /view.svg, one connection at a time.
class LivePage {
public:
    /// `port` 0: any that is free. Throws std::system_error.
    explicit LivePage(int port);
    [[nodiscard]] int port() const noexcept { return port_; }
    void show(std::string svg) { svg_ = std::move(svg); }
    /// Answers who has asked by now; waits no longer than `milliseconds` for one.
    void serve(int milliseconds);

private:
    void answer(int client) const;

    UniqueFd socket_;
    int port_ = 0;
    std::string svg_;
};

}  // namespace sc::host::cli
