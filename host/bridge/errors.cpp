// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/errors.hpp"

namespace sc::host {

std::string describe_code(std::uint16_t number) {
    const CodeText* code = find_code(number);
    std::string text = "code " + std::to_string(number);
    if (code != nullptr) {
        text += " " + std::string(code->name) + ": " + std::string(code->text);
        if (!code->action.empty()) {
            text += " (" + std::string(code->action) + ")";
        }
    }
    return text;
}

}  // namespace sc::host
