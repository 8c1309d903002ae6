// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include "boards/sim/lock_step.hpp"
#include "tests/stm32h743/cell/board_cell.hpp"

namespace {

volatile bool stop_asked = false;
void ask_stop(int) { stop_asked = true; }

}  // namespace

/// The modelled board as a cell for one host after another, until SIGTERM; then its report on stdout.
int main(int argc, char** argv) {
    try {
        CLI::App app{"The board stm32h743 on a modelled chip, with modelled buses, drives, head and laser.",
                     "scribecell-stm32h743-cell"};
        app.footer(
            "Example:\n  scribecell-stm32h743-cell --world world.toml --lockstep cell.socket\n"
            "      and, beside it: scribecell scribe --link lockstep:cell.socket");
        std::filesystem::path world;
        std::filesystem::path socket;
        sc::stm32h743::cell::BoardCell::Options options;
        bool classic = false;
        app.add_option("--world", world, "world file")->required()->check(CLI::ExistingFile);
        app.add_option("--lockstep", socket, "where to listen for hosts")->required();
        app.add_flag("--classic", classic, "the host speaks classic CAN frames, not FD");
        CLI11_PARSE(app, argc, argv);
        options.host_fd = !classic;
        struct sigaction action{};
        action.sa_handler = ask_stop;
        ::sigaction(SIGTERM, &action, nullptr);
        ::sigaction(SIGINT, &action, nullptr);
        sc::stm32h743::cell::BoardCell cell(sc::sim::read_world_spec(world), options);
        (void)sc::sim::serve_lock_step(cell, socket, {}, &stop_asked);
        std::printf("%s\n", to_json(cell.report()).c_str());
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-stm32h743-cell: %s\n", error.what());
        return 1;
    }
}
