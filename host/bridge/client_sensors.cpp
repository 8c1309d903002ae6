// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstdio>

#include "host/bridge/client.hpp"
#include "shared/path/item.hpp"

namespace sc::host {
namespace {

/// A measurement takes up to a second of a sensor that is lost, and the answer comes at the end.
constexpr Nanoseconds kPerSample = std::chrono::milliseconds(1100);

std::string millimetres(std::int64_t wire) {
    std::array<char, 32> text{};
    (void)std::snprintf(text.data(), text.size(), "%+.3f mm", static_cast<double>(wire) * 1e3 / kWireUnitsPerMetre);
    return text.data();
}

}  // namespace

std::string describe_seating(Refusal refusal, std::int64_t detail) {
    if (refusal == Refusal::seating_no_value) {
        return "sensor " + std::to_string(detail / 1000) + ": " +
               describe_code(static_cast<std::uint16_t>(detail % 1000));
    }
    if (refusal == Refusal::seating_off) {
        return "by " + millimetres(detail) + " (+ is further away)";
    }
    if (refusal == Refusal::seating_tilted) {
        return "by " + millimetres(detail) + " from sensor to sensor";
    }
    return refusal == Refusal::seating_swapped ? "they fit in the order " + std::to_string(detail) : "";
}

void CellClient::set_surface(const link::SetSurface& surface) {
    if (minor() < link::SetSurface::kSince && surface.mode == 0) {
        return;
    }
    // A controller that knows no looks would check the surface where its sensor is, not where the beam is.
    require(surface.mode == 0 ? link::SetSurface::kSince : std::uint8_t{2}, "let its Y sensor look at the surface");
    link::SetSurface message = surface;
    const auto send = [&](std::uint32_t sequence) {
        message.sequence = sequence;
        wire_.send(message);
    };
    request(send, "set the use of the Y sensor");
}

void CellClient::check_seating(const link::CheckSeating& seating) {
    require(link::CheckSeating::kSince, "check the workpiece's seat");
    link::CheckSeating message = seating;
    const auto send = [&](std::uint32_t sequence) {
        message.sequence = sequence;
        wire_.send(message);
    };
    const int attempts = options_.attempts;
    options_.attempts += static_cast<int>((seating.samples + 2) * kPerSample / options_.reply_wait);
    try {
        request(send, "check the workpiece's seat");
    } catch (const CellRefused& refused) {
        options_.attempts = attempts;
        const std::string more = describe_seating(refused.refusal, refused.detail);
        if (more.empty()) {
            throw;
        }
        throw CellRefused(std::string(refused.what()) + " (" + more + ")", refused.refusal, refused.detail);
    } catch (...) {
        options_.attempts = attempts;
        throw;
    }
    options_.attempts = attempts;
}

link::SensorReport CellClient::read_sensors() {
    require(link::SensorsRequest::kSince, "tell what its sensors say");
    sensors_.reset();
    if (!repeat_until([this] { wire_.send(link::SensorsRequest{}); }, [this] { return sensors_.has_value(); })) {
        throw LinkError("the cell does not tell what its sensors say");
    }
    return *sensors_;
}

void CellClient::take(const link::SensorReport& message) { sensors_ = message; }

}  // namespace sc::host
