// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "boards/drive_check/cases.hpp"

namespace {

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr const char* kExamples = R"(Examples:
  scribecell-drive-check --can can0 --node 3 --real
      tries a real drive without moving it: is it one that the controller can use?
  scribecell-drive-check --can can0 --node 3 --real --moves
      moves and homes it too: stand clear, let the axis be free to run 10 mm either way
  scribecell-drive-check --can vcan1 --node 1 --json
      a simulated drive (scribecell-drive), whose time is that of the SYNCs

Exit codes: 0 every case passed or does not apply; 1 one failed; 2 bad usage, or no such interface.)";

struct Words {
    std::string can;
    int node = 1;
    double cycle_ms = 2.0;
    int patience_ms = 200;
    bool real = false;
    bool moves = false;
    bool json = false;
};

const char* name_of(sc::drive_check::Verdict verdict) {
    switch (verdict) {
        case sc::drive_check::Verdict::passed: return "passed";
        case sc::drive_check::Verdict::failed: return "FAILED";
        case sc::drive_check::Verdict::left_out: break;
    }
    return "left out";
}

int run(const Words& words) {
    using namespace sc::drive_check;
    CanPort port(sc::socketcan::CanSocket(words.can), words.cycle_ms, words.real, words.patience_ms);
    port.fence(static_cast<std::uint8_t>(words.node));
    DriveClient drive(port, static_cast<std::uint8_t>(words.node));
    nlohmann::ordered_json list = nlohmann::json::array();
    int failures = 0;
    int passes = 0;
    for (const Case& one : all_cases()) {
        const Result result = one.moves && !words.moves ? left_out("moves the axis: give --moves") : one.run(drive);
        failures += result.verdict == Verdict::failed ? 1 : 0;
        passes += result.verdict == Verdict::passed ? 1 : 0;
        if (words.json) {
            list.push_back({{"group", one.group},
                            {"case", one.name},
                            {"verdict", result.verdict == Verdict::failed ? "failed" : name_of(result.verdict)},
                            {"text", result.text}});
        } else {
            std::printf("%-14s %-52s %s%s%s\n", one.group.c_str(), one.name.c_str(), name_of(result.verdict),
                        result.text.empty() ? "" : ": ", result.text.c_str());
        }
    }
    if (words.json) {
        const nlohmann::ordered_json object{
            {"node", words.node}, {"passed", passes}, {"failed", failures}, {"cases", list}};
        std::printf("%s\n", object.dump(2).c_str());
    } else {
        std::printf("%d passed, %d failed\n", passes, failures);
    }
    return failures == 0 ? kDone : kFailed;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"Try on a CiA 402 drive what the controller needs of it.", "scribecell-drive-check"};
    Words words;
    try {
        constexpr int kMostNodes = 126;
        app.footer(kExamples);
        app.add_option("--can", words.can, "CAN interface")->required()->type_name("IFACE");
        app.add_option("--node", words.node, "node number of the drive")->check(CLI::Range(1, kMostNodes));
        app.add_option("--cycle-ms", words.cycle_ms, "drive cycle")->check(CLI::Range(1, 20))->capture_default_str();
        app.add_option("--patience-ms", words.patience_ms, "longest wait for an answer")
            ->check(CLI::Range(1, 10'000))
            ->capture_default_str();
        app.add_flag("--real", words.real, "a real drive: SYNCs come at the cycle");
        app.add_flag("--moves", words.moves, "the cases that move the axis too");
        app.add_flag("--json", words.json, "one JSON object");
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            return app.exit(error) == 0 ? kDone : kBadInput;
        }
        return run(words);
    } catch (const std::system_error& error) {
        std::fprintf(stderr, "scribecell-drive-check: %s\n", error.what());
        return kBadInput;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scribecell-drive-check: %s\n", error.what());
        return kFailed;
    }
}
