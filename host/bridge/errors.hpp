// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "shared/codes/codes.hpp"
#include "shared/codes/state.hpp"
#include "shared/path/item.hpp"

namespace sc::host {

/// Anything that ends an operation on the cell, though the input was good (exit code 1). `what()` is a full sentence.
class CellError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// The link cannot be opened, has closed, or nobody answers.
class LinkError : public CellError {
public:
    using CellError::CellError;
};

/// The cell refused a command, a connection or an item of a job.
class CellRefused : public CellError {
public:
    CellRefused(const std::string& what, Refusal refusal_code, std::int64_t refusal_detail)
        : CellError(what), refusal(refusal_code), detail(refusal_detail) {}
    Refusal refusal;
    std::int64_t detail;  ///< as in link::CommandReply, or the item's number
};

/// A fault has latched.
class CellFault : public CellError {
public:
    CellFault(const std::string& what, Fault fault_code, std::uint8_t fault_axis)
        : CellError(what), fault(fault_code), axis(fault_axis) {}
    Fault fault;
    std::uint8_t axis;
};

/// A person asked for the end (Ctrl-C, SIGTERM); exit code 130.
class Interrupted : public CellError {
public:
    Interrupted() : CellError("interrupted") {}
};

/// "number name: text; action", or "code N" for a number that the list lacks.
[[nodiscard]] std::string describe_code(std::uint16_t number);

}  // namespace sc::host
