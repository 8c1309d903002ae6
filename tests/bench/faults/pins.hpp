// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// What is seen of a cell from outside: the lines between controller and source, the axes, where light met the
/// workpiece, and what the host was told. Plain numbers, so that the oracle needs nothing of the firmware. Times in ns
/// of the cell's time, places in mm (C: degrees).

namespace sc::faults {

/// `guide_asked` is no pin: when the host has asked for the guide laser, to point by.
enum class Line : std::uint8_t { gate, trigger, master_oscillator, guide, shutter_coil, beam_way, guide_asked };

/// A level from this time on; a trigger is an edge.
struct LineEvent {
    std::int64_t t_ns = 0;
    Line line = Line::gate;
    bool level = false;
};

/// Each control period.
struct AxisSample {
    std::int64_t t_ns = 0;
    std::array<double, 4> place{};    ///< true
    std::array<double, 4> command{};  ///< the set-points as they left
};

/// Each control period: what the controller says of itself.
struct StateSample {
    std::int64_t t_ns = 0;
    std::string_view state;
    int first_fault = 0;  ///< number, 0: none
    bool yellow = false;  ///< emission warning
};

/// Light on the workpiece.
struct Burn {
    std::int64_t t_ns = 0;
    std::array<double, 3> place{};
};

/// What the host asked for after the fault.
struct Request {
    std::int64_t t_ns = 0;
    std::string_view verb;
    bool granted = false;
    bool cause_present = false;
};

struct Trace {
    std::vector<LineEvent> lines;
    std::vector<AxisSample> axes;
    std::vector<StateSample> states;
    std::vector<Burn> burns;
    std::vector<Request> requests;
    /// Light of the undisturbed job, in order: the path that may be burnt.
    const std::vector<Burn>* path = nullptr;
};

/// One combination.
struct Combination {
    std::string fault;
    std::string state;  ///< as it was when the fault came
    std::string phase;
    std::int64_t fault_ns = 0;
    std::int64_t cleared_ns = 0;  ///< the cause was taken away; 0: never
};

}  // namespace sc::faults
