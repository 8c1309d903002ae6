// SPDX-License-Identifier: Apache-2.0
#include "host/cli/failure.hpp"

#include <cstdio>
#include <exception>

#include <nlohmann/json.hpp>

#include "host/bridge/errors.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/exit_codes.hpp"
#include "host/formats/error.hpp"

namespace sc::host::cli {
namespace {

Failure of_code(std::uint16_t number, const char* message) {
    Failure failure;
    failure.exit_code = kFailed;
    failure.code = number;
    failure.name = "unknown";
    failure.message = message;
    if (const CodeText* code = find_code(number)) {
        failure.name = code->name;
        failure.action = code->action;
    }
    return failure;
}

Failure bad_input(const InputError& error) {
    return {.exit_code = kBadInput,
            .code = 0,
            .name = "bad_input",
            .message = error.what(),
            .action = error.action(),
            .file = error.file(),
            .line = error.line(),
            .value = error.value()};
}

Failure plain(int exit_code, const char* name, const char* message) {
    Failure failure;
    failure.exit_code = exit_code;
    failure.name = name;
    failure.message = message;
    return failure;
}

}  // namespace

Failure current_failure() {
    try {
        throw;
    } catch (const InputError& error) {
        return bad_input(error);
    } catch (const Interrupted& error) {
        return plain(kExitInterrupted, "interrupted", error.what());
    } catch (const CellFault& error) {
        return of_code(static_cast<std::uint16_t>(error.fault), error.what());
    } catch (const CellRefused& error) {
        return of_code(static_cast<std::uint16_t>(error.refusal), error.what());
    } catch (const LinkError& error) {
        return plain(kFailed, "link", error.what());
    } catch (const std::exception& error) {
        return plain(kFailed, "failed", error.what());
    }
}

nlohmann::ordered_json to_json(const Failure& failure) {
    nlohmann::ordered_json json{
        {"code", failure.code}, {"name", failure.name}, {"text", failure.message}, {"action", failure.action}};
    if (failure.exit_code == kBadInput) {
        json["file"] = failure.file;
        json["line"] = failure.line;
        json["value"] = failure.value;
    }
    return json;
}

void print_failure(const Failure& failure) { std::fprintf(stderr, "scribecell: %s\n", failure.message.c_str()); }

int guarded(bool json, const std::function<int()>& work) {
    try {
        return work();
    } catch (const std::exception&) {
        const Failure failure = current_failure();
        print_failure(failure);
        if (json) {
            const nlohmann::ordered_json object{{"error", to_json(failure)}};
            std::printf("%s\n", object.dump(2).c_str());
        }
        return failure.exit_code;
    }
}

}  // namespace sc::host::cli
