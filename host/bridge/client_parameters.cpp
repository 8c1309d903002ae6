// SPDX-License-Identifier: Apache-2.0
// The parameters that a controller keeps over a loss of power.
#include <algorithm>

#include "host/bridge/client.hpp"
#include "shared/hash/crc.hpp"
#include "shared/link/config.hpp"

namespace sc::host {

StoredParameters CellClient::read_parameters() {
    require(link::ParametersRequest::kSince, "tell its stored parameters");
    StoredParameters stored;
    for (;;) {
        const link::ParametersRequest wanted{static_cast<std::uint16_t>(stored.bytes.size())};
        parameters_.reset();
        const auto answered = [&] { return parameters_ && parameters_->offset == wanted.offset; };
        if (!repeat_until([&] { wire_.send(wanted); }, answered)) {
            throw LinkError("the cell does not tell its stored parameters");
        }
        const link::Parameters& told = *parameters_;
        if (!stored.bytes.empty() && told.generation != stored.generation) {
            stored = {};  // written anew in between
            continue;
        }
        stored.fitted = told.fitted != 0;
        stored.in_force = told.in_force != 0;
        stored.generation = told.generation;
        stored.layout = told.layout;
        const auto data = std::span(told.data).first(std::min<std::size_t>(told.count, told.data.size()));
        stored.bytes.insert(stored.bytes.end(), data.begin(), data.end());
        if (stored.bytes.size() >= told.bytes) {
            if (crc32(stored.bytes) != told.crc) {
                throw LinkError(
                    "the stored parameters came through damaged: report this, with the versions of both sides");
            }
            return stored;
        }
        if (data.empty()) {
            throw LinkError("the cell does not tell all of its stored parameters");
        }
    }
}

void CellClient::store_parameters(const std::optional<MachineConfig>& machine) {
    require(link::StoreParameters::kSince, "store parameters");
    std::array<std::uint8_t, link::kConfigSize> bytes{};
    link::StoreParameters store;
    store.layout = link::kConfigVersion;
    if (machine) {
        link::serialise(*machine, bytes);
        store.bytes = static_cast<std::uint16_t>(bytes.size());
        store.crc = crc32(bytes);
        send_pieces(bytes, "take a piece of the parameters");
    }
    const auto send = [&](std::uint32_t sequence) {
        store.sequence = sequence;
        wire_.send(store);
    };
    request(send, "store the parameters");
}

void CellClient::take(const link::Parameters& message) { parameters_ = message; }

}  // namespace sc::host
