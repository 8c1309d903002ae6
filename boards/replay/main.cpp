// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "boards/replay/key_file.hpp"
#include "boards/replay/log_file.hpp"
#include "boards/replay/replay_files.hpp"
#include "boards/replay/replay_text.hpp"
#include "boards/replay/replayer.hpp"
#include "boards/replay/state_text.hpp"

namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr const char* kExamples = R"(Examples:
  scribecell-replay run1/inputs.rec
      runs the controller with the recorded inputs and compares every tick's outputs
  scribecell-replay run1/inputs.rec --until 7310 --print-state
      stops after tick 7310 and tells how the controller stands
  scribecell-replay run1/inputs.rec --out replayed
      writes what was commanded, tick by tick and pulse by pulse, as tables
  scribecell-replay run1/inputs.rec --json --paint 0xA5
      one JSON object; the controller's memory is full of 0xA5 before it starts

Exit codes: 0 every tick is equal; 1 a tick differs, or the disk refuses; 2 bad input or usage.)";

struct Arguments {
    std::string log;
    std::optional<std::int64_t> until;
    std::optional<unsigned> paint;
    std::string key;
    std::string out;
    bool print_state = false;
    bool json = false;
};

void describe(CLI::App& app, Arguments& a) {
    app.footer(kExamples);
    app.add_option("log", a.log, "recording of a controller's inputs")->type_name("LOG")->required();
    app.add_option_function<std::int64_t>(
           "--until", [&a](const std::int64_t& tick) { a.until = tick; }, "last tick to run")
        ->type_name("TICK");
    app.add_option("--key", a.key, "file of the key, for a log of a cell that took sealed commands")->type_name("FILE");
    app.add_flag("--print-state", a.print_state, "tell how the controller stands after the last tick");
    app.add_option("--out", a.out, "folder for ticks.csv and commands.csv")->type_name("DIR");
    app.add_flag("--json", a.json, "one JSON object on stdout");
    app.add_option_function<unsigned>(
           "--paint", [&a](const unsigned& pattern) { a.paint = pattern; },
           "byte that fills the controller's memory and stack before it runs: nothing may depend on it")
        ->type_name("BYTE")
        ->check(CLI::Range(0U, 255U));
}

int run(const Arguments& a) {
    std::optional<sc::replay::ReplayFiles> files;
    sc::replay::ReplayOptions options;
    options.until = a.until;
    if (!a.key.empty()) {
        options.key = sc::replay::read_key_file(a.key);
    }
    if (a.paint) {
        options.paint = static_cast<std::uint8_t>(*a.paint);
    }
    options.on_tick = [&files](const sc::ServoInputs& inputs, const sc::ServoOutputs& outputs) {
        if (files) {
            files->tick(inputs, outputs);
        }
    };
    const std::vector<std::uint8_t> log = sc::replay::read_log_file(a.log);
    const auto replayer = std::make_unique<sc::replay::Replayer>(log, options);
    if (replayer->problem() != sc::recording::LogEnd::none) {
        std::fprintf(stderr, "scribecell-replay: %s\n",
                     sc::replay::problem_text(a.log, replayer->problem(), replayer->reader()).c_str());
        return kBadInput;
    }
    if (replayer->lacks_key()) {
        std::fprintf(stderr,
                     "scribecell-replay: %s: this cell took sealed commands only, with %s; give its key: --key FILE\n",
                     a.log.c_str(), a.key.empty() ? "a key that is not in the log" : "another key than this");
        return kBadInput;
    }
    if (!a.out.empty()) {
        files.emplace(a.out);
    }
    const sc::replay::ReplayResult result = replayer->run();
    if (files) {
        files->close();
    }
    nlohmann::ordered_json state = nullptr;
    if ((a.print_state || result.difference) && replayer->outputs() != nullptr) {
        state = sc::replay::state_json(replayer->controller(), replayer->inputs(), *replayer->outputs(),
                                       replayer->reader().header().machine);
    }
    std::string problem = sc::replay::problem_text(a.log, result.end, replayer->reader());
    if (problem.empty() && result.ticks == 0) {
        problem = a.log + ": the log holds no whole chunk of ticks, so there is nothing to replay; use another copy";
    }
    if (a.json) {
        nlohmann::ordered_json json = sc::replay::result_json(a.log, *replayer, result);
        json["state"] = state;
        json["problem"] = problem.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(problem);
        std::printf("%s\n", json.dump(2).c_str());
    } else {
        std::fputs(sc::replay::result_text(a.log, *replayer, result).c_str(), stdout);
        std::fputs(state.is_null() ? "" : sc::replay::lines_of(state).c_str(), stdout);
    }
    if (!problem.empty()) {
        std::fprintf(stderr, "scribecell-replay: %s\n", problem.c_str());
        if (result.ticks > 0 && !result.difference) {
            std::fprintf(stderr, "scribecell-replay: the %llu ticks before it are equal\n",
                         static_cast<unsigned long long>(result.ticks));
        }
        return kBadInput;
    }
    return result.equal() ? 0 : kFailed;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Runs the controller again with recorded inputs, and compares its outputs.", "scribecell-replay"};
    try {
        Arguments arguments;
        describe(app, arguments);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? 0 : kBadInput;
        }
        return run(arguments);
    } catch (const std::invalid_argument& error) {
        std::fprintf(stderr, "scribecell-replay: %s\n", error.what());
        return kBadInput;
    } catch (const std::system_error& error) {
        std::fprintf(stderr, "scribecell-replay: %s\n", error.what());
        return kBadInput;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-replay: %s\n", error.what());
        return kFailed;
    }
}
