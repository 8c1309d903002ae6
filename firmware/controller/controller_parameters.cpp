// SPDX-License-Identifier: Apache-2.0
// The parameters that outlive the power: taken over the link, kept by the store, told again.
#include <algorithm>
#include <span>
#include <variant>

#include "firmware/controller/controller.hpp"
#include "shared/link/config.hpp"

namespace sc {

Controller::Verdict Controller::store_parameters(const link::StoreParameters& m) noexcept {
    if (!geometry_may_change() || store_.busy()) {
        return {Refusal::wrong_state, static_cast<std::int64_t>(state())};
    }
    if (!store_.fitted()) {
        return {Refusal::parameters_not_kept, 0};
    }
    std::span<const std::uint8_t> bytes;
    if (m.bytes > 0) {
        const MapIntake* const intake = std::get_if<MapIntake>(&intake_);
        if (m.layout != link::kConfigVersion || intake == nullptr || !intake->whole(m.bytes, m.crc)) {
            return {Refusal::parameters_bad, intake == nullptr ? 0 : static_cast<std::int64_t>(intake->size())};
        }
        bytes = intake->bytes();
        MachineConfig machine;
        if (link::deserialise_into(machine, bytes) != Refusal::none) {
            return {Refusal::parameters_bad, 0};
        }
    }
    store_.begin(bytes, m.layout);
    store_sequence_ = m.sequence;
    return {};
}

/// A unit a tick, and none while the laser may come on: it is not armed before all is written.
void Controller::keep_parameters() noexcept {
    switch (store_.step(!safety::mo_state(state()))) {
        case store::ParameterStore::Progress::idle:
        case store::ParameterStore::Progress::writing: break;
        case store::ParameterStore::Progress::done: link_.reply(store_sequence_, Refusal::none, 0); break;
        case store::ParameterStore::Progress::failed:
            link_.reply(store_sequence_, Refusal::parameters_not_written, 0);
            break;
    }
}

link::Parameters Controller::parameters(std::uint16_t offset) const noexcept {
    link::Parameters told;
    told.fitted = store_.fitted() ? 1 : 0;
    told.offset = offset;
    const auto stored = store_.stored();
    if (!stored) {
        return told;
    }
    told.in_force = stored->generation == generation_in_force_ ? 1 : 0;
    told.generation = stored->generation;
    told.layout = stored->layout;
    told.bytes = static_cast<std::uint16_t>(stored->bytes.size());
    told.crc = stored->crc;
    const std::size_t from = std::min<std::size_t>(offset, stored->bytes.size());
    const auto run = stored->bytes.subspan(from, std::min(stored->bytes.size() - from, link::Parameters::kBytes));
    std::ranges::copy(run, told.data.begin());
    told.count = static_cast<std::uint8_t>(run.size());
    return told;
}

}  // namespace sc
