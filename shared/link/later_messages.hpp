// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "shared/link/messages.hpp"

/// Messages that minor versions have added. A minor version only adds messages, never changes one, so two peers talk
/// with those of the older of them (schema.hpp has a hash for each minor version). `kSince` is the first that has it.

namespace sc::link {

/// The first minor version that has a message.
template <class Message>
[[nodiscard]] constexpr std::uint8_t since() noexcept {
    if constexpr (requires { Message::kSince; }) {
        return Message::kSince;
    } else {
        return 0;
    }
}

// --- host to controller -------------------------------------------------------------------------------------------

/// Opens a job that has been burnt in part: the items before `first` are done and do not come, item `first` begins the
/// path of whose pulses those before `pulse` are done. Answered by CommandReply. The hash of what comes must end in
/// the job's, from `hash_before` on.
struct JobResume {
    static constexpr std::uint8_t kId = 12;
    static constexpr std::uint8_t kSince = 1;
    static constexpr std::string_view kName = "job_resume";
    std::uint32_t sequence = 0;
    std::uint64_t job = 0;          ///< hash of all the job's items
    std::uint32_t items = 0;        ///< all of the job
    std::uint32_t first = 0;        ///< a path_begin, a turn or job_end
    std::uint64_t hash_before = 0;  ///< of the items before `first`
    std::int32_t c = 0;             ///< angle of C that `first` begins at, wire units
    std::uint32_t path = 0;         ///< the first path and its pass, if it is burnt in part
    std::uint8_t pass = 0;
    std::uint32_t pulse = 0;  ///< pulses of it that are done: the first to fire has this number
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("job", m.job), v("items", m.items), v("first", m.first);
        v("hash_before", m.hash_before), v("c", m.c), v("path", m.path), v("pass", m.pass);
        v("pulse", m.pulse);
    }
};

/// Asks how far the last job came. Answered by Position with the same token.
struct PositionRequest {
    static constexpr std::uint8_t kId = 13;
    static constexpr std::uint8_t kSince = 1;
    static constexpr std::string_view kName = "position_request";
    std::uint32_t token = 0;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("token", m.token);
    }
};

/// Which channels of telemetry.hpp the controller is to send, and each group of them how often. Answered by
/// CommandReply; takes the place of the subscription before and ends with the session. No channels: none any more.
/// Refused with telemetry_over_budget, `detail` the period in ticks that would fit if no group had a shorter one, and
/// with bad_config for channels that are not known (1) or a period that is none (2).
struct TelemetryRequest {
    static constexpr std::uint8_t kId = 15;
    static constexpr std::uint8_t kSince = 2;
    static constexpr std::string_view kName = "telemetry_request";
    static constexpr std::size_t kGroups = 4;
    std::uint32_t sequence = 0;
    std::uint32_t channels = 0;                         ///< bits of TelemetryChannel
    std::array<std::uint16_t, kGroups> period_ticks{};  ///< of each TelemetryGroup that has a channel here
    std::uint32_t line_bytes_per_s = 0;                 ///< what the carrier takes to the host; 0: not known
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("channels", m.channels), v("period_ticks", m.period_ticks);
        v("line_bytes_per_s", m.line_bytes_per_s);
    }
};

/// Asks for records of the black box (blackbox.hpp) from a number on. Answered by BlackboxChunk.
struct BlackboxRequest {
    static constexpr std::uint8_t kId = 16;
    static constexpr std::uint8_t kSince = 2;
    static constexpr std::string_view kName = "blackbox_request";
    std::uint8_t part = 0;  ///< BlackboxPart
    std::uint32_t first = 0;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("part", m.part), v("first", m.first);
    }
};

/// Asks a controller that has a key for a challenge (seal.hpp). Not sealed itself. Answered by SealChallenge; the same
/// nonce again is answered with the same challenge.
struct SealRequest {
    static constexpr std::uint8_t kId = 23;
    static constexpr std::uint8_t kSince = 3;
    static constexpr std::string_view kName = "seal_request";
    std::uint32_t session = 0;
    std::array<std::uint8_t, 16> nonce{};  ///< drawn by the host, new for each session
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("session", m.session), v("nonce", m.nonce);
    }
};

/// Opens or resumes a sealed session, in place of Hello: answered by HelloReply. Not sealed: `proof` stands for it.
/// All that the host sends from now on is sealed, with counters above `first`.
struct SealHello {
    static constexpr std::uint8_t kId = 24;
    static constexpr std::uint8_t kSince = 3;
    static constexpr std::string_view kName = "seal_hello";
    std::uint32_t session = 0;
    std::uint32_t challenge = 0;  ///< number of the challenge that it answers
    std::uint16_t heartbeat_timeout_ms = 100;
    std::uint16_t first = 0;  ///< the counters of sealed messages go on from here
    std::array<std::uint8_t, 8> proof{};
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("session", m.session), v("challenge", m.challenge), v("heartbeat_timeout_ms", m.heartbeat_timeout_ms);
        v("first", m.first), v("proof", m.proof);
    }
};

// --- controller to host -------------------------------------------------------------------------------------------

/// How far a job has come, for a host that lost sight of it. Pulses up to the first position have left for certain,
/// none beyond the second has; the two are equal but for a moment while light is on, and after a fault or a loss of
/// power that came then.
struct Position {
    static constexpr std::uint8_t kId = 70;
    static constexpr std::uint8_t kSince = 1;
    static constexpr std::string_view kName = "position";
    std::uint32_t token = 0;
    std::uint8_t source = 0;  ///< PositionSource
    std::uint64_t job = 0;    ///< hash of its items
    std::uint32_t items = 0;
    std::uint32_t fired = 0;  ///< every item below is done for certain
    std::uint32_t path = 0;
    std::uint8_t pass = 0;
    std::uint32_t pulses = 0;  ///< fired for certain in this pass
    std::uint32_t reached_path = 0;
    std::uint8_t reached_pass = 0;
    std::uint32_t reached_pulses = 0;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("token", m.token), v("source", m.source), v("job", m.job), v("items", m.items), v("fired", m.fired);
        v("path", m.path), v("pass", m.pass), v("pulses", m.pulses), v("reached_path", m.reached_path);
        v("reached_pass", m.reached_pass), v("reached_pulses", m.reached_pulses);
    }
};
enum class PositionSource : std::uint8_t {
    none = 0,      ///< no job that the controller knows of
    memory = 1,    ///< of this start of the controller
    retained = 2,  ///< from before it, from memory that keeps its content without power
};

/// Which items are wanted though later ones have come (selective repeat): runs [from, until), rising, `count` of them.
/// `heard` is the counter of the newest message taken: what was sent with it or before and is listed is lost, what was
/// sent after it may be on its way. Sent at once when a gap shows, and with acknowledgements while it stays.
struct StreamMissing {
    static constexpr std::uint8_t kId = 71;
    static constexpr std::uint8_t kSince = 1;
    static constexpr std::string_view kName = "stream_missing";
    static constexpr std::size_t kRuns = 4;
    std::uint32_t job_low = 0;
    std::uint16_t heard = 0;
    std::uint8_t count = 0;
    std::array<std::uint32_t, kRuns> from{};
    std::array<std::uint32_t, kRuns> until{};
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("job_low", m.job_low), v("heard", m.heard), v("count", m.count), v("from", m.from), v("until", m.until);
    }
};

/// The parameters that have come in map_chunks are to be kept without power: bytes of a configuration's layout
/// (config.hpp), their number and CRC-32; 0 bytes: nothing is to be kept any more. They are in force from the
/// controller's next start. Answered by CommandReply once they are written.
struct StoreParameters {
    static constexpr std::uint8_t kId = 18;
    static constexpr std::uint8_t kSince = 2;
    static constexpr std::string_view kName = "store_parameters";
    std::uint32_t sequence = 0;
    std::uint16_t layout = 0;
    std::uint16_t bytes = 0;
    std::uint32_t crc = 0;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("layout", m.layout), v("bytes", m.bytes), v("crc", m.crc);
    }
};

/// Asks for the parameters that are kept, from a byte offset on. Answered by Parameters.
struct ParametersRequest {
    static constexpr std::uint8_t kId = 19;
    static constexpr std::uint8_t kSince = 2;
    static constexpr std::string_view kName = "parameters_request";
    std::uint16_t offset = 0;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("offset", m.offset);
    }
};

/// Answers a heartbeat, one each 50 ms at most: the heartbeat's own time stamp, the controller's time when it had come
/// for certain, and before this answer left. The true times lie within a control period of these.
struct ClockReply {
    static constexpr std::uint8_t kId = 72;
    static constexpr std::uint8_t kSince = 2;
    static constexpr std::string_view kName = "clock_reply";
    std::uint64_t host_time_us = 0;
    std::uint64_t received_us = 0;  ///< not before the heartbeat's last byte came
    std::uint64_t sent_us = 0;      ///< not after this message's first byte left
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("host_time_us", m.host_time_us), v("received_us", m.received_us), v("sent_us", m.sent_us);
    }
};

/// One sample of the channels that are due: their values in the order of their bits (telemetry.hpp).
struct Telemetry {
    static constexpr std::uint8_t kId = 73;
    static constexpr std::uint8_t kSince = 2;
    static constexpr std::string_view kName = "telemetry";
    std::uint32_t channels = 0;  ///< in this sample
    std::uint64_t cell_time_us = 0;
    std::uint16_t skipped = 0;  ///< samples of this subscription that found no room on the line, so far
    Bytes values;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("channels", m.channels), v("cell_time_us", m.cell_time_us), v("skipped", m.skipped), v("values", m.values);
    }
};

/// Whole records of one part of the black box, from number `first` on; those from `begin` to before `end` are there.
struct BlackboxChunk {
    static constexpr std::uint8_t kId = 74;
    static constexpr std::uint8_t kSince = 2;
    static constexpr std::string_view kName = "blackbox_chunk";
    static constexpr std::size_t kBytes = 210;  ///< 7 samples or 26 events
    std::uint8_t part = 0;
    std::uint32_t first = 0;
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    std::uint8_t frozen = 0;      ///< 1: by a fault, and nothing is written until the axes are powered again
    std::uint8_t fault = 0;       ///< that froze it
    std::uint8_t axis = 0;        ///< of that fault, 255 = none
    std::uint64_t newest_us = 0;  ///< cell's time of the newest sample; frozen: of the fault
    std::uint32_t period_ns = 0;  ///< control period: a tick of the records
    std::uint8_t count = 0;       ///< records here
    std::array<std::uint8_t, kBytes> records{};
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("part", m.part), v("first", m.first), v("begin", m.begin), v("end", m.end), v("frozen", m.frozen);
        v("fault", m.fault), v("axis", m.axis), v("newest_us", m.newest_us), v("period_ns", m.period_ns);
        v("count", m.count), v("records", m.records);
    }
};

/// Parameters that are kept: which, and a run of their bytes.
struct Parameters {
    static constexpr std::uint8_t kId = 79;
    static constexpr std::uint8_t kSince = 2;
    static constexpr std::string_view kName = "parameters";
    static constexpr std::size_t kBytes = 200;  ///< of one run
    std::uint8_t fitted = 0;                    ///< 1: the board can keep any
    std::uint8_t in_force = 0;                  ///< 1: this start of the controller runs with them
    std::uint32_t generation = 0;               ///< counts what was stored; 0: nothing is
    std::uint16_t layout = 0;
    std::uint16_t bytes = 0;
    std::uint32_t crc = 0;  ///< CRC-32 of all of them
    std::uint16_t offset = 0;
    std::uint8_t count = 0;  ///< bytes of `data` that are some
    std::array<std::uint8_t, kBytes> data{};
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("fitted", m.fitted), v("in_force", m.in_force), v("generation", m.generation), v("layout", m.layout);
        v("bytes", m.bytes), v("crc", m.crc), v("offset", m.offset), v("count", m.count), v("data", m.data);
    }
};

/// What a host must answer to open a sealed session, and the controller's own proof that it has the key (seal.hpp).
struct SealChallenge {
    static constexpr std::uint8_t kId = 81;
    static constexpr std::uint8_t kSince = 3;
    static constexpr std::string_view kName = "seal_challenge";
    std::uint32_t session = 0;
    std::uint32_t challenge = 0;           ///< number, since the controller's start
    std::array<std::uint8_t, 16> nonce{};  ///< of the controller; never the same again, over its starts too
    std::array<std::uint8_t, 8> proof{};
    std::uint32_t blocks_per_s = 0;  ///< of 16 sealed bytes that are checked in time; what comes faster may be lost
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("session", m.session), v("challenge", m.challenge), v("nonce", m.nonce), v("proof", m.proof);
        v("blocks_per_s", m.blocks_per_s);
    }
};

}  // namespace sc::link
