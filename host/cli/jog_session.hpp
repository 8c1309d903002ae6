// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "host/bridge/client.hpp"
#include "host/bridge/transport.hpp"
#include "host/cli/jog_moves.hpp"

/// What a calibration by jogs has in common: a cell that is asked to move, read, and left at rest.

namespace sc::host::cli {

struct JogLink {
    std::string link = "sim:";
    std::optional<std::filesystem::path> world{};  ///< of the simulated cell
    std::uint64_t seed = 1;
    std::optional<std::filesystem::path> key{};  ///< file of the cell's key
};

class JogSession {
public:
    /// Opens the link and connects. Throws LinkError, CellRefused, InputError, Interrupted.
    explicit JogSession(const JogLink& link);

    [[nodiscard]] CellClient& client() noexcept { return client_; }

    /// Clears what stands in the way, powers and homes the axes, lets `work` move them, and brings the cell to rest,
    /// also when something is thrown. Steps are told on stderr.
    void run(const std::function<void(JogMoves&)>& work);

private:
    std::unique_ptr<Transport> transport_;
    CellClient client_;
};

}  // namespace sc::host::cli
