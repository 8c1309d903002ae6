// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/client.hpp"
#include "host/bridge/machine_parameters.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/number_text.hpp"
#include "host/cli/subcommands.hpp"
#include "host/formats/error.hpp"
#include "shared/link/config.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell params --link serial:/dev/ttyUSB0
      each parameter in force, and what is stored where that differs
  scribecell params x.speed_mm_s=400 settle_ms=30 --link serial:/dev/ttyUSB0
      store these; they are in force from the controller's next start
  scribecell params --reset --link serial:/dev/ttyUSB0
      forget what is stored: what the board was built with counts from the next start
  scribecell params --memory retained.bin c.speed_deg_s=20
      the same for a simulated cell, which keeps them in retained.bin.parameters

Counts, nodes, wiring and sensors are the board's own. Nothing is written while the laser is armed.)";

struct ParamsOptions {
    std::string link = "sim:";
    LinkOptions link_options;
    std::vector<std::string> settings;
    bool reset = false;
    bool json = false;
};

/// A number as a person would have written it.
std::string shown(double value) { return number_text(std::abs(value) < 1e15 ? std::round(value * 1e9) / 1e9 : value); }

void check(const ParamsOptions& options) {
    if (options.reset && !options.settings.empty()) {
        throw InputError({.file = {},
                          .problem = "--reset forgets all that is stored, so there is nothing to set with it",
                          .value = options.settings.front(),
                          .action = "leave one of them out"});
    }
    if (!is_simulated(options.link) && options.link_options.memory) {
        throw InputError({.file = {},
                          .problem = "--memory belongs to the simulated cell",
                          .value = options.link,
                          .action = "give it to `scribecell cell`, or use --link sim:"});
    }
    for (const std::string& setting : options.settings) {
        const std::string name = setting.substr(0, setting.find('='));
        if (find_parameter(name) == nullptr || setting.find('=') == std::string::npos) {
            MachineConfig machine = reference_machine();
            set_parameter(machine, setting);  // says what is wrong
        }
    }
}

void show_json(const MachineConfig& now, const StoredParameters& stored, const std::optional<MachineConfig>& next) {
    nlohmann::ordered_json out;
    out["fitted"] = stored.fitted;
    out["generation"] = stored.generation;
    out["in_force"] = stored.in_force;
    for (const MachineParameter& parameter : machine_parameters()) {
        out["parameters"][parameter.name] = parameter.get(now);
        if (next) {
            out["stored"][parameter.name] = parameter.get(*next);
        }
    }
    std::printf("%s\n", out.dump(2).c_str());
}

void show(const MachineConfig& now, const StoredParameters& stored, const std::optional<MachineConfig>& next) {
    std::size_t width = 0;
    for (const MachineParameter& parameter : machine_parameters()) {
        width = std::max(width, parameter.name.size());
    }
    for (const MachineParameter& parameter : machine_parameters()) {
        const std::string value = shown(parameter.get(now));
        std::string differs;
        if (next && shown(parameter.get(*next)) != value) {
            differs = fmt::format("  (stored: {}, from the next start)", shown(parameter.get(*next)));
        }
        fmt::print("{:{}}  {:>12}  {}{}\n", parameter.name, width, value, parameter.text, differs);
    }
    if (!stored.fitted) {
        fmt::print("this board has no memory for parameters: these are what it was built with\n");
    } else if (stored.generation == 0) {
        fmt::print("nothing is stored: these are what the board was built with\n");
    } else {
        fmt::print("stored: version {} of the parameters{}\n", stored.generation,
                   stored.in_force ? ", in force" : "; not in force before the controller's next start");
    }
}

/// What is stored, if this program knows its layout.
std::optional<MachineConfig> machine_in(const StoredParameters& stored) {
    if (stored.generation == 0 || stored.layout != link::kConfigVersion) {
        return std::nullopt;
    }
    const auto machine = link::deserialise(stored.bytes);
    return machine ? std::optional(*machine) : std::nullopt;
}

int run(const ParamsOptions& options) {
    check(options);
    install_stop_signals();
    const auto transport = open_transport(options.link, options.link_options);
    CellClient client(*transport, client_options(options.link_options, std::random_device{}()));
    client.set_stop_check(stop_requested);
    client.connect();
    const MachineConfig now = client.read_config();
    StoredParameters stored = client.read_parameters();
    if (options.reset) {
        client.store_parameters(std::nullopt);
    } else if (!options.settings.empty()) {
        MachineConfig wanted = machine_in(stored).value_or(now);
        for (const std::string& setting : options.settings) {
            set_parameter(wanted, setting);
        }
        client.store_parameters(wanted);
    }
    if (options.reset || !options.settings.empty()) {
        stored = client.read_parameters();
    }
    const std::optional<MachineConfig> next = machine_in(stored);
    if (options.json) {
        show_json(now, stored, next);
    } else {
        show(now, stored, next);
    }
    return 0;
}

}  // namespace

void add_params(CLI::App& app, int& exit_code) {
    CLI::App* sub = app.add_subcommand("params", "Parameters that a controller keeps without power.");
    sub->footer(kExamples);
    const auto options = std::make_shared<ParamsOptions>();
    sub->add_option("SETTING", options->settings, "NAME=VALUE to store")->type_name("");
    sub->add_option("--link", options->link, "the cell")->type_name("URL")->capture_default_str();
    add_key_option(*sub, options->link_options.key);
    sub->add_flag("--reset", options->reset, "forget what is stored");
    sub->add_flag("--json", options->json, "one JSON object");
    sub->add_option("--memory", options->link_options.memory, "what the simulated cell keeps without power")
        ->type_name("FILE");
    sub->callback([options, &exit_code] { exit_code = guarded(options->json, [&] { return run(*options); }); });
}

}  // namespace sc::host::cli
