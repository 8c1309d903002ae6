// SPDX-License-Identifier: Apache-2.0
#include "boards/replay/replay_files.hpp"

#include <cerrno>
#include <stdexcept>
#include <system_error>

#include "boards/replay/state_text.hpp"

namespace sc::replay {
namespace {

std::ofstream open_table(const std::filesystem::path& file, const char* columns) {
    std::ofstream stream(file);
    if (!stream) {
        throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(), file.string());
    }
    stream << columns << "\n";
    return stream;
}

}  // namespace

ReplayFiles::ReplayFiles(const std::filesystem::path& folder) : folder_(folder) {
    std::filesystem::create_directories(folder_);
    ticks_ = open_table(folder_ / "ticks.csv",
                        "tick,state,faults,x_pm,y_pm,z_pm,c_ndeg,mirror_x_pm,mirror_z_pm,gate,cancel,pulses,"
                        "link_bytes_in,link_bytes_out,drive_frames_in,drive_frames_out");
    commands_ = open_table(folder_ / "commands.csv", "tick,path,pass,number,s_pm,x_pm,y_pm,z_pm,energy_code,t_ns");
}

void ReplayFiles::tick(const ServoInputs& inputs, const ServoOutputs& out) {
    ticks_ << inputs.tick << ',' << name_of_state(out.state) << ',' << out.faults;
    for (const std::int64_t set_point : out.set_point) {
        ticks_ << ',' << set_point;
    }
    ticks_ << ',' << out.galvo[0].x_pm << ',' << out.galvo[0].z_pm << ',' << out.gate_allowed << ',' << out.cancel_laser
           << ',' << out.pulses_size << ',' << inputs.link_rx.size() << ',' << out.link_tx_size << ','
           << inputs.drive_rx.size() << ',' << out.drive_tx_size << '\n';
    for (const PathPulse& pulse : std::span(out.pulses).first(out.pulses_size)) {
        commands_ << inputs.tick << ',' << pulse.path << ',' << int{pulse.pass} << ',' << pulse.number << ','
                  << pulse.s_pm;
        for (const std::int64_t place : pulse.place_pm) {
            commands_ << ',' << place;
        }
        commands_ << ',' << int{pulse.energy_code} << ',' << pulse.t_ns << '\n';
    }
}

void ReplayFiles::close() {
    ticks_.close();
    commands_.close();
    if (!ticks_ || !commands_) {
        throw std::runtime_error(folder_.string() + ": the tables could not be written to the end");
    }
}

}  // namespace sc::replay
