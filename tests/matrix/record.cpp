// SPDX-License-Identifier: Apache-2.0
// Records the log that every build must replay: crosses by the mirrors, lines with blends, a hold and its resume, and
// a drive's fault in a second job.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "boards/mps2_an500/pc/m7_controller.hpp"
#include "tests/sim/firmware/controller/cell_rig.hpp"

namespace {

/// Pulses of the first job are fewer: the fault comes in the second.
constexpr std::size_t kFaultAfterPulses = 6000;

/// The short job, and a line that bends a little at each of its points, at no even angle: each corner is another blend.
std::vector<sc::Item> job() {
    std::vector<sc::Item> items = sc::test::short_job();
    items.pop_back();
    sc::PathBegin begin;
    begin.path = 9;
    begin.speed_um_s = 47'000;
    begin.pitch_nm = 17'300;
    begin.energy_nj = 300'000;
    begin.tolerance_nm = 9'000;
    items.emplace_back(begin);
    std::uint32_t random = 2463534242U;
    const auto off = [&random] {
        random = random * 1664525U + 1013904223U;
        return static_cast<std::int32_t>(random >> 16U) % 9000 - 4500;
    };
    for (std::int32_t i = 0; i < 60; ++i) {
        items.emplace_back(
            sc::PathPoint{-27'123'457 + 70'003 * i + off(), -31'900'000 + off() / 8, -38'777'771 + off()});
    }
    items.emplace_back(sc::PathEnd{});
    items.emplace_back(sc::JobEnd{});
    return items;
}

bool begin_job(sc::test::CellRig& rig) {
    return rig.open_job(job()).refusal == 0 && rig.command(sc::link::Verb::start).refusal == 0;
}

/// Such as a calibration might find: without it the map from places to axes is the identity, and rounds nothing.
sc::Compensation compensation() {
    sc::Compensation c;
    c.axis_from_h.row[0] = {1.00003, 0.00017, -0.00011};
    c.axis_from_h.row[1] = {-0.00007, 0.99998, 0.00021};
    c.axis_from_h.row[2] = {0.00013, -0.00019, 1.00004};
    c.axis_offset = {12e-6, -7e-6, 31e-6};
    c.galvo_from_field = {1.0021, 0.0007, -0.0013, 0.9987};
    c.galvo_offset = {-3e-6, 9e-6};
    return c;
}

/// False when the cell did not do what the log is to show.
bool run(sc::test::CellRig& rig) {
    rig.connect();
    if (!rig.until_state(sc::State::disabled, 5000) || rig.set_compensation(compensation()).refusal != 0) {
        return false;
    }
    rig.make_ready();
    if (!begin_job(rig) || !rig.until([&] { return rig.path_pulses().size() > 900; })) {
        return false;
    }
    if (rig.command(sc::link::Verb::hold).refusal != 0 || !rig.until_state(sc::State::held, 5000) ||
        rig.command(sc::link::Verb::resume).refusal != 0 ||
        !rig.until([&] { return (rig.status().flags & sc::link::kFlagJobDone) != 0; }) ||
        rig.pulses().size() >= kFaultAfterPulses) {
        return false;
    }
    if (!begin_job(rig) || !rig.until_state(sc::State::fault)) {
        return false;
    }
    rig.ticks(300);
    return rig.cell().report().first_fault == sc::Fault::drive_fault;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2 && argc != 3) {
        std::fprintf(stderr, "usage: matrix_record LOG [IMAGE]   with an image: on the Cortex-M7\n");
        return 2;
    }
    try {
        const std::filesystem::path log = argv[1];
        std::filesystem::create_directories(log.parent_path());
        sc::test::CellRig::Options options;
        options.script = "pulse " + std::to_string(kFaultAfterPulses) + " drive x fault 0x2310";
        options.record = log;
        if (argc == 3) {
            options.controller = sc::mps2_an500::make_m7_controller({.image = argv[2]});
        }
        sc::test::CellRig rig(options);
        if (!run(rig)) {
            std::fprintf(stderr, "matrix_record: the cell did not run as planned, it stands in state %s\n",
                         std::string(sc::name_of(rig.state())).c_str());
            return 1;
        }
        rig.cell().close();
        std::printf("%llu ticks, %zu pulses, command_trace_sha256 %s\n",
                    static_cast<unsigned long long>(rig.cell().record()->ticks()), rig.path_pulses().size(),
                    rig.command_hash().c_str());
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "matrix_record: %s\n", error.what());
        return 1;
    }
}
