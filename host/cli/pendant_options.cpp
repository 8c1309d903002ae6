// SPDX-License-Identifier: Apache-2.0
#include "host/cli/pendant_options.hpp"

#include <CLI/CLI.hpp>

#include "host/formats/error.hpp"
#include "host/pendant/hid_port.hpp"
#include "host/pendant/script_port.hpp"

namespace sc::host::cli {

void add_pendant_options(CLI::App& app, PendantWords& words) {
    app.add_flag("--pendant", words.used, "a USB pendant beside the keyboard (docs/pendant.md)");
    app.add_option("--pendant-device", words.device, "its file; without it the first one that is found")
        ->type_name("/dev/hidrawN");
    app.add_option("--pendant-reports", words.reports, "events from a file in place of a pendant")->type_name("FILE");
}

std::unique_ptr<pendant::PendantPort> open_pendant(const PendantWords& words) {
    if (!words.reports.empty() && !words.device.empty()) {
        throw InputError({.problem = "the pendant is named twice",
                          .value = words.device,
                          .action = "give its device or a file of reports"});
    }
    if (!words.reports.empty()) {
        return std::make_unique<pendant::ScriptPort>(words.reports);
    }
    return std::make_unique<pendant::HidPort>(words.device);
}

}  // namespace sc::host::cli
