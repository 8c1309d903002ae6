// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <string>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/cli/bench_figures.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kProgram = "scribecell-motion-bench";

std::filesystem::path program() {
    const auto found = find_program(kProgram);
    if (!found) {
        throw CellError(std::string("the program ") + kProgram +
                        " is not there: build it (./run does), or set SCRIBECELL_ROOT");
    }
    return *found;
}

/// All that the child writes to its socket, until it closes it.
std::string read_all(int socket) {
    std::string text;
    char part[4096];
    while (true) {
        const ssize_t count = ::read(socket, part, sizeof part);
        if (count < 0 && errno == EINTR) {
            continue;
        }
        if (count <= 0) {
            return text;
        }
        text.append(part, static_cast<std::size_t>(count));
    }
}

}  // namespace

std::vector<Figure> bench_motion(const BenchOptions&) {
    const auto root = find_project_root();
    if (!root) {
        throw CellError("tests/data/motion is not beside this program: set SCRIBECELL_ROOT to the project's folder");
    }
    ChildProcess child(program(), {"--workloads", (*root / "tests/data/motion").string(), "--json", "--output-fd",
                                   std::to_string(ChildProcess::kChildSocket)});
    const std::string text = read_all(child.socket());
    // Broken limits end the program with 1; the figures say which, and are judged by the caller.
    const int code = child.finish();
    const auto object = nlohmann::json::parse(text, nullptr, false);
    if (!object.is_object()) {
        throw CellError(std::string(kProgram) + " ended with " + std::to_string(code) + " and gave no figures");
    }
    const auto figure = [&](const char* name, const char* unit) {
        return Figure{name, object.at(name).get<double>(), unit};
    };
    return {figure("a_dense_s", "s"),        figure("b_corners_s", "s"),       figure("c_mixed_s", "s"),
            figure("max_limit_ratio", ""),   figure("max_deviation_um", "um"), figure("plan_us_per_point", "us"),
            figure("worst_insert_us", "us"), figure("horizon_256_ratio", "")};
}

int bench_motion_file(const MotionFile& file, bool json) {
    std::vector<std::string> words{program().string(), "--input", file.input};
    if (!file.limits.empty()) {
        words.insert(words.end(), {"--limits", file.limits});
    }
    if (!file.tolerance.empty()) {
        words.insert(words.end(), {"--tolerance", file.tolerance});
    }
    if (json) {
        words.emplace_back("--json");
    }
    std::vector<char*> argv;
    for (std::string& word : words) {
        argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    ::execv(words.front().c_str(), argv.data());
    throw std::system_error(errno, std::generic_category(), "cannot start " + words.front());
}

}  // namespace sc::host::cli
