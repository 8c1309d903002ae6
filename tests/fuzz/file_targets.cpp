// SPDX-License-Identifier: Apache-2.0
// Readers of files that people and other programs write. A refusal (InputError) is the right answer to bad input;
// anything else that is thrown is a bug.
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <unistd.h>

#include "host/formats/blank_model.hpp"
#include "host/formats/calibration_set.hpp"
#include "host/formats/eds.hpp"
#include "host/formats/error.hpp"
#include "host/formats/job.hpp"
#include "host/formats/journal.hpp"
#include "host/formats/lag_plate.hpp"
#include "host/formats/mesh.hpp"
#include "host/formats/part.hpp"
#include "host/formats/plate.hpp"
#include "host/formats/points.hpp"
#include "host/formats/pulse_trace.hpp"
#include "host/formats/recipe.hpp"
#include "host/formats/scan.hpp"
#include "host/formats/scan_set.hpp"
#include "host/formats/stand.hpp"
#include "host/formats/station_job.hpp"
#include "host/formats/stations.hpp"
#include "host/formats/table.hpp"
#include "host/formats/target.hpp"
#include "host/pendant/script_port.hpp"
#include "tests/fuzz/targets.hpp"

namespace sc::fuzz {
namespace {

/// The input as a file; it goes with the program, whatever ends that.
std::filesystem::path file_of(Bytes input, std::string_view extension) {
    static const std::filesystem::path folder = [] {
        const std::filesystem::path made = "/dev/shm/scribecell-fuzz-" + std::to_string(::getpid());
        std::filesystem::create_directory(made);
        std::atexit([] { std::filesystem::remove_all("/dev/shm/scribecell-fuzz-" + std::to_string(::getpid())); });
        return made;
    }();
    const std::filesystem::path file = folder / ("input." + std::string(extension));
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
    return file;
}

template <auto Read>
void read_as(Bytes input, std::string_view extension) {
    try {
        static_cast<void>(Read(file_of(input, extension)));
    } catch (const host::InputError&) {
        return;
    }
}

constexpr auto kMesh = [](const std::filesystem::path& path) { return host::read_mesh(path); };
constexpr auto kScan = [](const std::filesystem::path& path) { return host::read_scan(path); };
constexpr auto kTable = [](const std::filesystem::path& path) { return host::read_table(path); };

template <auto Read>
void toml(Bytes input) {
    read_as<Read>(input, "toml");
}
template <auto Read>
void csv(Bytes input) {
    read_as<Read>(input, "csv");
}

constexpr std::array kTargets{
    Target{"job", toml<host::read_job>},
    Target{"calibration", toml<host::read_calibration>},
    Target{"recipe", toml<host::read_recipe>},
    Target{"part", toml<host::read_part>},
    Target{"blank_model", toml<host::read_blank_model>},
    Target{"scan_set", toml<host::read_scan_set>},
    Target{"target", toml<host::read_target>},
    Target{"stand", toml<host::read_stand>},
    Target{"eds", [](Bytes input) { read_as<host::read_eds>(input, "eds"); }},
    Target{"station_job", toml<host::read_station_job>},
    Target{"stations", csv<host::read_stations>},
    Target{"known", csv<host::read_known>},
    Target{"points", csv<host::read_points>},
    Target{"route", csv<host::read_route>},
    Target{"table", csv<kTable>},
    Target{"plate_plan", csv<host::read_plate_plan>},
    Target{"measured_crosses", csv<host::read_measured_crosses>},
    Target{"lag_plan", csv<host::read_lag_plan>},
    Target{"lag_marks", csv<host::read_lag_marks>},
    Target{"journal", [](Bytes input) { read_as<host::read_journal>(input, "journal"); }},
    Target{"pulse_trace", [](Bytes input) { read_as<host::read_pulse_trace>(input, "bin"); }},
    Target{"sample_header", [](Bytes input) { read_as<host::read_sample_header>(input, "bin"); }},
    Target{"mesh_stl", [](Bytes input) { read_as<kMesh>(input, "stl"); }},
    Target{"mesh_obj", [](Bytes input) { read_as<kMesh>(input, "obj"); }},
    Target{"scan_ply", [](Bytes input) { read_as<kScan>(input, "ply"); }},
    Target{"scan_pcd", [](Bytes input) { read_as<kScan>(input, "pcd"); }},
    Target{"pendant_script",
           [](Bytes input) {
               try {
                   static_cast<void>(host::pendant::parse_script({input.begin(), input.end()}, "input.txt"));
               } catch (const host::InputError&) {
                   return;
               }
           }},
    Target{"scan_xyz", [](Bytes input) { read_as<kScan>(input, "xyz"); }},
};

}  // namespace

std::span<const Target> file_targets() noexcept { return kTargets; }

}  // namespace sc::fuzz
