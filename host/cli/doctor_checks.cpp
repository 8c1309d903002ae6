// SPDX-License-Identifier: Apache-2.0
#include "host/cli/doctor_checks.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

#include "host/bridge/child_process.hpp"
#include "host/bridge/client.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/cli/scribe_input.hpp"

namespace sc::host::cli {
namespace {

namespace fs = std::filesystem;

std::string read_all(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::string joined(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) {
        text += (text.empty() ? "" : " ") + word;
    }
    return text;
}

/// Names in a folder that begin with one of `prefixes`, sorted.
std::vector<std::string> names_in(const fs::path& folder, const std::vector<std::string>& prefixes) {
    std::vector<std::string> names;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder, failed)) {
        const std::string name = entry.path().filename().string();
        const bool wanted = std::any_of(prefixes.begin(), prefixes.end(),
                                        [&](const std::string& prefix) { return name.starts_with(prefix); });
        if (wanted) {
            names.push_back((folder / name).string());
        }
    }
    std::sort(names.begin(), names.end());
    return names;
}

Check packages(const fs::path& root, const std::string& tier, bool needed, const std::string& status) {
    Check check{.name = "packages " + tier, .good = true, .needed = needed, .found = "all installed", .action = {}};
    const fs::path list = root / "packages" / (tier + ".txt");
    const std::vector<std::string> missing = missing_packages(read_all(list), status);
    if (!fs::exists(list)) {
        check.good = false;
        check.found = "the list " + list.string() + " is missing";
        check.action = "set SCRIBECELL_ROOT to the project's folder";
    } else if (!missing.empty()) {
        check.good = false;
        check.found = "missing: " + joined(missing);
        check.action = "apt-get install -y --no-install-recommends " + joined(missing);
    }
    return check;
}

void add_packages(std::vector<Check>& checks, const fs::path& root) {
    const std::string status = read_all("/var/lib/dpkg/status");
    if (status.empty()) {
        checks.push_back({"packages", false, false, "no Debian packages on this system",
                          "install the like of packages/core.txt and packages/host.txt"});
        return;
    }
    checks.push_back(packages(root, "core", true, status));
    checks.push_back(packages(root, "host", true, status));
    checks.push_back(packages(root, "test", false, status));
}

Check example(const fs::path& root) {
    Check check{"example job", true, true, (root / "examples/ras3dm/job.toml").string(), ""};
    try {
        ScribeOptions options;
        options.job = root / "examples/ras3dm/job.toml";
        const ScribeInput input = read_input(options);
        const Planned planned = plan_for(input, reference_machine());
        check.found += ": " + std::to_string(planned.plan.paths.size()) + " lines to burn; calibration " +
                       input.calibration.id + (input.calibration.axis_map ? " with" : " without") + " an axis map";
    } catch (const std::exception& error) {
        check.good = false;
        check.found = error.what();
        check.action = "restore examples/ras3dm from the project";
    }
    return check;
}

Check simulated_cell() {
    Check check{.name = "simulated cell", .good = false, .needed = true, .found = {}, .action = {}};
    const auto program = find_program("scribecell-cell");
    if (!program) {
        check.found = "the program scribecell-cell is missing";
        check.action = "build it: ./run does";
        return check;
    }
    try {
        const auto transport = open_transport("sim:", {});
        CellClient client(*transport, {});
        client.connect();
        static_cast<void>(client.read_config());
        check.good = true;
        check.found = program->string() + " answers";
    } catch (const std::exception& error) {
        check.found = error.what();
        check.action = "build again: ./run does; then report it";
    }
    return check;
}

Check devices(const std::string& name, const std::vector<std::string>& found, const std::string& action) {
    return {name, !found.empty(), false, found.empty() ? "none" : joined(found), action};
}

Check path_exists(const std::string& name, const fs::path& path, const std::string& action) {
    std::error_code failed;
    const bool there = fs::exists(path, failed);
    return {name, there, false, there ? path.string() : path.string() + " is missing", action};
}

void add_kernel(std::vector<Check>& checks) {
    const bool realtime = read_all("/sys/kernel/realtime").starts_with('1');
    checks.push_back({"kernel: PREEMPT_RT", realtime, false, realtime ? "yes" : "no",
                      "for the board linux_rt only: apt-get install linux-image-rt-amd64, then boot it"});
    checks.push_back(path_exists("kernel: SocketCAN", "/proc/net/can", "for CAN links only: modprobe can_raw"));
    checks.push_back(path_exists("kernel: vcan", "/sys/module/vcan", "for tests of CAN links only: modprobe vcan"));
    checks.push_back(devices("kernel: GPIO", names_in("/dev", {"gpiochip"}),
                             "for the board linux_rt only: a kernel with GPIO character devices"));
    checks.push_back(devices("kernel: hidraw", names_in("/dev", {"hidraw"}), "for a pendant only: plug it in"));
}

}  // namespace

std::vector<std::string> missing_packages(std::string_view list, std::string_view dpkg_status) {
    std::set<std::string, std::less<>> installed;
    std::istringstream status{std::string(dpkg_status)};
    std::string package;
    for (std::string line; std::getline(status, line);) {
        if (line.starts_with("Package: ")) {
            package = line.substr(9);
        } else if (line == "Status: install ok installed" || line == "Status: hold ok installed") {
            installed.insert(package);
        }
    }
    std::vector<std::string> missing;
    std::istringstream wanted{std::string(list)};
    for (std::string line; std::getline(wanted, line);) {
        line.erase(std::find(line.begin(), line.end(), '#'), line.end());
        std::istringstream words(line);
        for (std::string word; words >> word;) {
            if (!installed.contains(word)) {
                missing.push_back(word);
            }
        }
    }
    return missing;
}

std::vector<Check> all_checks() {
    std::vector<Check> checks;
    const auto root = find_project_root();
    checks.push_back({"project folder", root.has_value(), true, root ? root->string() : "not found",
                      "set SCRIBECELL_ROOT to the project's folder"});
    if (root) {
        add_packages(checks, *root);
        checks.push_back(example(*root));
    }
    checks.push_back(simulated_cell());
    add_kernel(checks);
    checks.push_back(devices("serial lines", names_in("/dev", {"ttyUSB", "ttyACM", "ttyAMA"}),
                             "for a cell on a serial line only: plug the adapter in"));
    return checks;
}

}  // namespace sc::host::cli
