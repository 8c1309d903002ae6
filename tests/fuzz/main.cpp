// SPDX-License-Identifier: Apache-2.0
// One program for all targets, so that the libraries are linked once: SC_FUZZ_TARGET says which it is.
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "tests/fuzz/targets.hpp"

namespace {

void (*chosen)(sc::fuzz::Bytes) = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*count*/, char*** /*arguments*/) {
    const char* const wanted = std::getenv("SC_FUZZ_TARGET");
    for (const auto& list : {sc::fuzz::wire_targets(), sc::fuzz::file_targets()}) {
        for (const sc::fuzz::Target& target : list) {
            if (wanted != nullptr && target.name == wanted) {
                chosen = target.run;
            } else if (wanted == nullptr) {
                std::printf("%.*s\n", static_cast<int>(target.name.size()), target.name.data());
            }
        }
    }
    if (chosen == nullptr) {
        std::exit(wanted == nullptr ? 0 : 2);
    }
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    chosen({data, size});
    return 0;
}
