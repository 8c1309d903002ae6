// SPDX-License-Identifier: Apache-2.0
#include "host/cli/black_box_file.hpp"

#include <chrono>
#include <exception>

#include <fmt/chrono.h>

#include "host/bridge/errors.hpp"
#include "host/cli/black_box_text.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {

std::string keep_black_box(CellClient& client, const std::filesystem::path& folder) {
    const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
    const std::filesystem::path file = folder / fmt::format("blackbox-{:%Y%m%dT%H%M%SZ}.csv", fmt::gmtime(now));
    try {
        const BlackBoxContent content = client.read_black_box();
        write_text_file(file, black_box_csv(content, client.clock()));
        return "the cell's last seconds before the fault are in " + file.string();
    } catch (const Interrupted&) {
        throw;
    } catch (const std::exception& error) {
        return std::string("the cell's black box could not be kept: ") + error.what();
    }
}

}  // namespace sc::host::cli
