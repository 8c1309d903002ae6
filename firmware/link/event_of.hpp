// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "firmware/link/endpoint.hpp"
#include "shared/link/schema.hpp"

namespace sc::link {

/// Which event a request becomes, and where its content goes.
template <LinkEvent::Kind Kind, auto Body>
struct Event {
    static constexpr LinkEvent::Kind kKind = Kind;
    static constexpr auto kBody = Body;
};
template <class Message>
struct EventOf;
template <>
struct EventOf<Command> : Event<LinkEvent::Kind::command, &LinkEvent::command> {};
template <>
struct EventOf<JobOpen> : Event<LinkEvent::Kind::job_open, &LinkEvent::job_open> {};
template <>
struct EventOf<JobResume> : Event<LinkEvent::Kind::job_resume, &LinkEvent::job_resume> {};
template <>
struct EventOf<PositionRequest> : Event<LinkEvent::Kind::position_request, &LinkEvent::position_request> {};
template <>
struct EventOf<SetCompensation> : Event<LinkEvent::Kind::compensation, &LinkEvent::compensation> {};
template <>
struct EventOf<MapChunk> : Event<LinkEvent::Kind::map_chunk, &LinkEvent::map_chunk> {};
template <>
struct EventOf<SetMap> : Event<LinkEvent::Kind::set_map, &LinkEvent::set_map> {};
template <>
struct EventOf<SetGalvoField> : Event<LinkEvent::Kind::galvo_field, &LinkEvent::galvo_field> {};
template <>
struct EventOf<SetPowerCurve> : Event<LinkEvent::Kind::power_curve, &LinkEvent::power_curve> {};
template <>
struct EventOf<SetGalvoLag> : Event<LinkEvent::Kind::galvo_lag, &LinkEvent::galvo_lag> {};
template <>
struct EventOf<SetSurface> : Event<LinkEvent::Kind::surface, &LinkEvent::surface> {};
template <>
struct EventOf<CheckSeating> : Event<LinkEvent::Kind::seating, &LinkEvent::seating> {};
template <>
struct EventOf<StoreParameters> : Event<LinkEvent::Kind::store_parameters, &LinkEvent::store_parameters> {};

using RequestMessages =
    MessageList<Command, JobOpen, JobResume, PositionRequest, SetCompensation, MapChunk, SetMap, SetGalvoField,
                SetPowerCurve, SetGalvoLag, SetSurface, CheckSeating, StoreParameters>;

}  // namespace sc::link
