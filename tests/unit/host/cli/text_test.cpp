// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/bridge/errors.hpp"
#include "host/cli/doctor_checks.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/monitor_text.hpp"
#include "host/cli/override_keys.hpp"
#include "host/cli/progress_printer.hpp"
#include "host/cli/scribe_input.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

TEST(ClockText, RoundsUpToWholeSeconds) {
    EXPECT_EQ(clock_text(Nanoseconds(0)), "0:00");
    EXPECT_EQ(clock_text(Nanoseconds(1)), "0:01");
    EXPECT_EQ(clock_text(std::chrono::seconds(59)), "0:59");
    EXPECT_EQ(clock_text(std::chrono::seconds(61)), "1:01");
    EXPECT_EQ(clock_text(std::chrono::seconds(3600 + 125)), "1:02:05");
    EXPECT_EQ(clock_text(Nanoseconds(-5)), "0:00");
}

TEST(OverrideKeys, StepWithinWhatACellTakes) {
    EXPECT_EQ(override_after('+', 100), std::uint8_t{110});
    EXPECT_EQ(override_after('=', 195), std::uint8_t{200});
    EXPECT_EQ(override_after('+', 200), std::uint8_t{200});
    EXPECT_EQ(override_after('-', 100), std::uint8_t{90});
    EXPECT_EQ(override_after('-', 15), std::uint8_t{10});
    EXPECT_EQ(override_after('0', 30), std::uint8_t{100});
    for (const char key : {'q', ' ', '\n', '1'}) {
        EXPECT_FALSE(override_after(key, 100).has_value());
    }
}

TEST(MissingPackages, FindsWhatIsNotInstalledOrWasRemoved) {
    const char* status =
        "Package: one\nStatus: install ok installed\n\n"
        "Package: two\nStatus: deinstall ok config-files\n\n"
        "Package: four\nStatus: install ok installed\n";
    EXPECT_EQ(missing_packages("# list\none\n two # why\nthree\n\nfour\n", status),
              (std::vector<std::string>{"two", "three"}));
    EXPECT_TRUE(missing_packages("", status).empty());
    EXPECT_EQ(missing_packages("one\n", ""), (std::vector<std::string>{"one"}));
}

Failure failure_of(const std::exception_ptr& thrown) {
    try {
        std::rethrow_exception(thrown);
    } catch (...) {
        return current_failure();
    }
}

TEST(Failure, EachKindHasItsExitCodeAndItsNumber) {
    const Failure input = failure_of(std::make_exception_ptr(
        InputError({.file = "a.csv", .line = 7, .problem = "no number", .value = "x", .action = "write one"})));
    EXPECT_EQ(input.exit_code, 2);
    EXPECT_EQ(input.file, "a.csv");
    EXPECT_EQ(input.line, 7);
    EXPECT_EQ(to_json(input)["value"], "x");
    const Failure fault = failure_of(std::make_exception_ptr(CellFault("stopped", Fault::encoder_frozen, 0)));
    EXPECT_EQ(fault.exit_code, 1);
    EXPECT_EQ(fault.code, 8);
    EXPECT_EQ(fault.name, "encoder_frozen");
    EXPECT_FALSE(fault.action.empty());
    EXPECT_FALSE(to_json(fault).contains("file"));
    const Failure refused = failure_of(std::make_exception_ptr(CellRefused("no", Refusal::not_homed, 0)));
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_EQ(refused.code, 104);
    EXPECT_EQ(failure_of(std::make_exception_ptr(LinkError("gone"))).exit_code, 1);
    EXPECT_EQ(failure_of(std::make_exception_ptr(Interrupted())).exit_code, 130);
    EXPECT_EQ(failure_of(std::make_exception_ptr(std::runtime_error("x"))).exit_code, 1);
}

TEST(StatusText, NamesStateFaultsAxesAndFlags) {
    link::Status status;
    status.state = static_cast<std::uint8_t>(State::fault);
    status.faults = fault_bit(Fault::encoder_frozen) | fault_bit(Fault::estop_open);
    status.first_fault = static_cast<std::uint8_t>(Fault::encoder_frozen);
    status.first_fault_axis = 2;
    status.flags = link::kFlagHomed;
    status.actual = {-31'409'000, 0, 0, -9'000'000};
    const std::string text = status_text(status, {});
    for (const char* part : {"fault", "code 8 encoder_frozen", "<- first, axis Z", "code 1 estop_open",
                             "X -314.0900 mm", "C -90.0000 deg", "homed yes", "gate_open no"}) {
        EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
    }
    const auto json = status_json(status, {});
    EXPECT_EQ(json["state"], "fault");
    EXPECT_EQ(json["faults"].size(), 2U);
    EXPECT_EQ(json["faults"][1]["code"], 8);
    EXPECT_EQ(json["flags"]["homed"], true);
    EXPECT_EQ(json["c_deg"], -90.0);
}

TEST(MachineText, TellsTravelAndKeepOut) {
    const std::string text = machine_text(reference_machine());
    EXPECT_NE(text.find("-450"), std::string::npos) << text;
    EXPECT_NE(text.find("keep-out"), std::string::npos) << text;
    EXPECT_EQ(machine_json(reference_machine())["axes"].size(), 4U);
}

TEST(DescribeItem, LeadsBackToFileAndLine) {
    JobPlan plan;
    PlannedPath path;
    path.kind = PathKind::cross_vertical;
    path.marker = 5;
    path.face_deg = 90.0;
    path.first_item = 10;
    path.item_count = 4;
    path.source = {"points.csv", 6};
    plan.paths.push_back(path);
    const std::string text = describe_item(plan, 13);
    for (const char* part : {"marker 5", "face 90", "points.csv line 6"}) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    }
    EXPECT_EQ(describe_item(plan, 14).find("points.csv"), std::string::npos);
    EXPECT_EQ(describe_item(plan, 9).find("points.csv"), std::string::npos);
}

}  // namespace
}  // namespace sc::host::cli
