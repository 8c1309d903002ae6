// SPDX-License-Identifier: Apache-2.0
#include "host/cli/jog_session.hpp"

#include <cstdio>
#include <random>

#include "host/bridge/open_transport.hpp"
#include "host/bridge/session.hpp"
#include "host/bridge/stop.hpp"

namespace sc::host::cli {
namespace {

LinkOptions options_of(const JogLink& link) {
    LinkOptions out;
    out.world = link.world;
    out.seed = link.seed;
    out.key = link.key;
    return out;
}

/// A simulated run depends on its inputs and seed alone; on a wire two hosts must not draw the same number.
std::uint32_t session_number(const JogLink& link) {
    return is_simulated(link.link) ? static_cast<std::uint32_t>(link.seed) + 1U : std::random_device{}();
}

}  // namespace

JogSession::JogSession(const JogLink& link)
    : transport_(open_transport(link.link, options_of(link))),
      client_(*transport_, client_options(options_of(link), session_number(link))) {
    client_.set_stop_check(stop_requested);
    client_.connect();
}

void JogSession::run(const std::function<void(JogMoves&)>& work) {
    SessionOptions options;
    options.on_step = [](const std::string& what) { std::fprintf(stderr, "%s\n", what.c_str()); };
    Session session(client_, options);
    try {
        session.clear();
        session.enable_and_home();
        JogMoves moves(client_);
        work(moves);
    } catch (const std::exception&) {
        session.make_safe();
        throw;
    }
    session.make_safe();
}

}  // namespace sc::host::cli
