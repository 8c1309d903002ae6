// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// Messages between host and controller. Each has a number, a name and one visitor, from which encoder, decoder and the
/// schema's hash are all made (codec.hpp, schema.hpp). The order of fields is the order on the wire; integers are
/// little-endian, doubles IEEE 754 bits. To change a message is to change the hash, and both sides refuse to talk to
/// another hash. What a minor version adds is in later_messages.hpp. Hello and HelloReply alone must stay as they are,
/// since they carry the hash to a peer that has another.

namespace sc::link {

inline constexpr std::uint8_t kProtocolMajor = 1;
/// Newest minor version; every older one of this major is understood too.
inline constexpr std::uint8_t kProtocolMinor = 3;
/// Largest payload of one message.
inline constexpr std::size_t kPayloadCapacity = 240;

/// A short run of bytes inside a message: u8 length, then the bytes.
struct Bytes {
    std::array<std::uint8_t, 224> data{};
    std::uint8_t size = 0;
};

/// Feed override, percent.
inline constexpr std::uint8_t kMinOverride = 10;
inline constexpr std::uint8_t kMaxOverride = 200;

enum class Verb : std::uint8_t {
    enable = 1,  ///< power the axes
    disable = 2,
    home = 3,
    arm = 4,  ///< master oscillator on, wait, ready to mark
    disarm = 5,
    start = 6,  ///< run the opened job as its items arrive
    hold = 7,
    resume = 8,
    abort = 9,  ///< stop on the path, drop the job
    reset_fault = 10,
    jog = 11,           ///< arg0 axis, arg1 distance (wire units), arg2 speed (µm/s; C: 1e-3 °/s)
    stop = 12,          ///< stop a jog or a homing
    set_override = 13,  ///< arg0: feed of paths in percent of the programmed one, kMinOverride..kMaxOverride; any state
    preview = 14,       ///< trace the opened job as its items arrive with the guide laser; from idle, back to idle
    set_pulse_width = 15,  ///< arg0: ns, of the source; answered when the source has answered
    guide =
        16,  ///< arg0: 1 the guide laser on, from idle; it stays on through jogs and goes with any other state; 0 off
    lasers_in_turn = 20,  ///< arg0: 1 the lasers of the triple head one at a time, 0 all on
};

// --- host to controller -------------------------------------------------------------------------------------------

struct Hello {
    static constexpr std::uint8_t kId = 1;
    static constexpr std::string_view kName = "hello";
    std::uint64_t schema = 0;
    std::uint8_t major = kProtocolMajor;
    std::uint8_t minor = kProtocolMinor;
    std::uint32_t session = 0;  ///< drawn by the host; a reconnect of the same session may go on with its job
    std::uint16_t heartbeat_timeout_ms = 100;  ///< 20..500
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("schema", m.schema), v("major", m.major), v("minor", m.minor), v("session", m.session);
        v("heartbeat_timeout_ms", m.heartbeat_timeout_ms);
    }
};

/// Sent at least three times within the heartbeat timeout.
struct Heartbeat {
    static constexpr std::uint8_t kId = 2;
    static constexpr std::string_view kName = "heartbeat";
    std::uint64_t host_time_us = 0;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("host_time_us", m.host_time_us);
    }
};

/// Answered by CommandReply with the same `sequence`. Repeated with the same sequence it is answered again, not done
/// again. Sequences are shared with JobOpen and SetCompensation and rise within a session: one that is older than the
/// newest taken, and was never answered, is refused.
struct Command {
    static constexpr std::uint8_t kId = 3;
    static constexpr std::string_view kName = "command";
    std::uint32_t sequence = 0;
    std::uint8_t verb = 0;
    std::int32_t arg0 = 0;
    std::int32_t arg1 = 0;
    std::int32_t arg2 = 0;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("verb", m.verb), v("arg0", m.arg0), v("arg1", m.arg1), v("arg2", m.arg2);
    }
};

/// Opens a job: an empty queue that expects item 0. Answered by CommandReply. The same (job, items) again keeps what
/// has arrived.
struct JobOpen {
    static constexpr std::uint8_t kId = 4;
    static constexpr std::string_view kName = "job_open";
    std::uint32_t sequence = 0;
    std::uint64_t job = 0;    ///< hash of the job's items
    std::uint32_t items = 0;  ///< how many will come
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("job", m.job), v("items", m.items);
    }
};

/// Items first .. first + count − 1 of the job, coded as in block.hpp. Answered by StreamAck.
struct Block {
    static constexpr std::uint8_t kId = 5;
    static constexpr std::string_view kName = "block";
    std::uint32_t job_low = 0;  ///< low 32 bits of JobOpen::job
    std::uint32_t first = 0;
    std::uint8_t count = 0;
    Bytes items;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("job_low", m.job_low), v("first", m.first), v("count", m.count), v("items", m.items);
    }
};

/// Geometry that calibration measured (shared/machine Compensation). Answered by CommandReply; refused while anything
/// moves.
struct SetCompensation {
    static constexpr std::uint8_t kId = 6;
    static constexpr std::string_view kName = "set_compensation";
    std::uint32_t sequence = 0;
    std::array<double, 9> axis_matrix{};
    std::array<double, 3> axis_offset{};
    std::array<double, 4> galvo_matrix{};
    std::array<double, 2> galvo_offset{};
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("axis_matrix", m.axis_matrix), v("axis_offset", m.axis_offset);
        v("galvo_matrix", m.galvo_matrix), v("galvo_offset", m.galvo_offset);
    }
};

/// Asks for the machine's configuration from a byte offset on (config.hpp). Answered by ConfigChunk.
struct ConfigRequest {
    static constexpr std::uint8_t kId = 7;
    static constexpr std::string_view kName = "config_request";
    std::uint16_t offset = 0;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("offset", m.offset);
    }
};

/// Bytes of an axis map (map_codec.hpp) from an offset on, in order; offset 0 begins anew. Answered by CommandReply.
struct MapChunk {
    static constexpr std::uint8_t kId = 8;
    static constexpr std::string_view kName = "map_chunk";
    std::uint32_t sequence = 0;
    std::uint16_t offset = 0;
    Bytes data;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("offset", m.offset), v("data", m.data);
    }
};

/// The pieces are whole: check them, and put the map in force. No bytes: no map any more. Answered by CommandReply;
/// refused while anything moves, and then the map before stays.
struct SetMap {
    static constexpr std::uint8_t kId = 9;
    static constexpr std::string_view kName = "set_map";
    std::uint32_t sequence = 0;
    std::uint16_t bytes = 0;
    std::uint32_t crc = 0;  ///< CRC-32 of all bytes
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("bytes", m.bytes), v("crc", m.crc);
    }
};

/// Field correction of the galvo in three dimensions (shared/machine GalvoField), in order: `first` counts the numbers
/// sent before. count 0 ends the row: with all numbers sent the correction takes effect at once, with none the one in
/// force is taken away. Anything out of order must begin again at 0. Answered by CommandReply; refused while anything
/// moves.
struct SetGalvoField {
    static constexpr std::uint8_t kId = 10;
    static constexpr std::string_view kName = "set_galvo_field";
    static constexpr std::size_t kNumbers = 24;
    std::uint32_t sequence = 0;
    std::uint16_t first = 0;
    std::uint8_t count = 0;  ///< of `numbers` in use
    std::array<double, kNumbers> numbers{};
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("first", m.first), v("count", m.count), v("numbers", m.numbers);
    }
};

/// Average power over the power byte, as measured (shared/machine PowerCurve); count 0: straight. Answered by
/// CommandReply, `detail` the first point that is not sound; refused while anything moves.
struct SetPowerCurve {
    static constexpr std::uint8_t kId = 11;
    static constexpr std::string_view kName = "set_power_curve";
    static constexpr std::size_t kPoints = 17;
    std::uint32_t sequence = 0;
    std::uint8_t count = 0;
    std::array<std::uint8_t, kPoints> bytes{};
    std::array<double, kPoints> watts{};
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("count", m.count), v("bytes", m.bytes), v("watts", m.watts);
    }
};

/// How the mirrors follow, as measured (shared/machine GalvoLag); all zero: the machine's own figures. Answered by
/// CommandReply, `detail` what is out of range (`fault_of`); refused while anything moves.
struct SetGalvoLag {
    static constexpr std::uint8_t kId = 14;
    static constexpr std::uint8_t kSince = 1;
    static constexpr std::string_view kName = "set_galvo_lag";
    std::uint32_t sequence = 0;
    std::uint32_t latency_ns = 0;
    double natural_frequency_hz = 0.0;
    double damping = 0.0;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("latency_ns", m.latency_ns), v("natural_frequency_hz", m.natural_frequency_hz),
            v("damping", m.damping);
    }
};

/// What the Y sensor is used for, and its beam (firmware/sensors/surface.hpp). Answered by CommandReply; refused while
/// anything moves.
struct SetSurface {
    static constexpr std::uint8_t kId = 20;
    static constexpr std::uint8_t kSince = 1;
    static constexpr std::string_view kName = "set_surface";
    std::uint32_t sequence = 0;
    std::uint8_t mode = 0;  ///< 0 off, 1 check, 2 follow
    std::array<double, 3>
        origin{};  ///< with the axes at q, reading r says: surface at q + origin + (r − zero) · direction
    std::array<double, 3> direction{};  ///< unit
    double zero = 0.0;                  ///< metres
    double window = 0.0;                ///< metres: surface from focus, along y
    double bound = 0.0;                 ///< metres: y is never shifted by more
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("mode", m.mode), v("origin", m.origin), v("direction", m.direction);
        v("zero", m.zero), v("window", m.window), v("bound", m.bound);
    }
};

/// Checks the workpiece's seat with the triple head. Answered by CommandReply once enough has been measured; a failed
/// check forbids to arm and to start until one passes or the session ends.
struct CheckSeating {
    static constexpr std::uint8_t kId = 21;
    static constexpr std::uint8_t kSince = 1;
    static constexpr std::string_view kName = "check_seating";
    std::uint32_t sequence = 0;
    std::array<std::int32_t, 3> expected{};  ///< distances; wire units
    std::int32_t tolerance = 0;              ///< of each; wire units
    std::int32_t tilt = 0;                   ///< of the three against each other; wire units
    std::uint8_t samples = 0;                ///< measurements averaged, 1..100
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("expected", m.expected), v("tolerance", m.tolerance), v("tilt", m.tilt);
        v("samples", m.samples);
    }
};

/// Asks for what the distance sensors say. Answered by SensorReport.
struct SensorsRequest {
    static constexpr std::uint8_t kId = 22;
    static constexpr std::uint8_t kSince = 1;
    static constexpr std::string_view kName = "sensors_request";
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& /*v*/, Self& /*m*/) {}
};

// --- controller to host -------------------------------------------------------------------------------------------

struct HelloReply {
    static constexpr std::uint8_t kId = 64;
    static constexpr std::string_view kName = "hello_reply";
    std::uint64_t schema = 0;
    std::uint8_t major = kProtocolMajor;
    std::uint8_t minor = kProtocolMinor;
    std::uint16_t refusal = 0;  ///< Refusal, 0 = session open
    std::uint32_t session = 0;
    std::uint32_t boot = 0;          ///< changes at each start of the controller
    std::uint16_t config_bytes = 0;  ///< size of the serialised MachineConfig
    std::uint32_t config_crc = 0;
    std::uint32_t last_sequence = 0;  ///< newest sequence taken in this session; a resuming host counts on from here
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("schema", m.schema), v("major", m.major), v("minor", m.minor), v("refusal", m.refusal),
            v("session", m.session);
        v("boot", m.boot), v("config_bytes", m.config_bytes), v("config_crc", m.config_crc);
        v("last_sequence", m.last_sequence);
    }
};

struct CommandReply {
    static constexpr std::uint8_t kId = 65;
    static constexpr std::string_view kName = "command_reply";
    std::uint32_t sequence = 0;
    std::uint16_t refusal = 0;  ///< Refusal, 0 = accepted (done or begun)
    std::int64_t detail = 0;    ///< what the refusal is about: axis, item, fault number
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("sequence", m.sequence), v("refusal", m.refusal), v("detail", m.detail);
    }
};

/// The three stages of each item: received, planned, fired. Cumulative: every item below the number has reached the
/// stage.
struct StreamAck {
    static constexpr std::uint8_t kId = 66;
    static constexpr std::string_view kName = "stream_ack";
    std::uint32_t job_low = 0;
    std::uint32_t received = 0;  ///< next item wanted
    std::uint32_t planned = 0;
    std::uint32_t fired = 0;
    std::uint16_t free_items = 0;  ///< the host may send items below received + free_items
    std::uint32_t path = 0;        ///< fired position
    std::uint8_t pass = 0;
    std::uint32_t pulses = 0;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("job_low", m.job_low), v("received", m.received), v("planned", m.planned), v("fired", m.fired);
        v("free_items", m.free_items), v("path", m.path), v("pass", m.pass), v("pulses", m.pulses);
    }
};

/// An item of the job was refused; the cell stops in good order and drops the job.
struct JobRefused {
    static constexpr std::uint8_t kId = 67;
    static constexpr std::string_view kName = "job_refused";
    std::uint32_t job_low = 0;
    std::uint32_t item = 0;
    std::uint16_t refusal = 0;
    std::uint8_t axis = 0;
    std::int64_t value = 0;  ///< wire units of the axis
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("job_low", m.job_low), v("item", m.item), v("refusal", m.refusal), v("axis", m.axis), v("value", m.value);
    }
};

/// State of the cell; every 20 ms and at each change of state. Also the controller's heartbeat.
struct Status {
    static constexpr std::uint8_t kId = 68;
    static constexpr std::string_view kName = "status";
    std::uint64_t cell_time_us = 0;
    std::uint8_t state = 0;    ///< shared/codes/state.hpp
    std::uint64_t faults = 0;  ///< bits by Fault
    std::uint8_t first_fault = 0;
    std::uint8_t first_fault_axis = 0;
    std::uint8_t limited_by = 0;           ///< LimitedBy, 0 = nothing moves
    std::uint8_t flags = 0;                ///< StatusFlag bits
    std::array<std::int32_t, 4> actual{};  ///< encoders; wire units
    std::uint32_t pulses_total = 0;        ///< since boot
    std::uint32_t frames_bad = 0;          ///< link frames dropped for checksum or form
    std::uint32_t messages_lost = 0;       ///< gaps in the message counter
    std::uint32_t items_repeated = 0;      ///< items that had arrived before
    std::uint32_t starvations = 0;
    std::uint8_t override_percent = 100;  ///< feed override in force
    std::uint32_t map_crc = 0;            ///< of the axis map in force, 0 = none
    std::uint8_t key = 0;                 ///< 0 off, 1 setup, 2 production
    std::uint8_t source = 0;              ///< SourceState (shared/machine/source_status.hpp)
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("cell_time_us", m.cell_time_us), v("state", m.state), v("faults", m.faults), v("first_fault", m.first_fault);
        v("first_fault_axis", m.first_fault_axis), v("limited_by", m.limited_by), v("flags", m.flags);
        v("actual", m.actual), v("pulses_total", m.pulses_total), v("frames_bad", m.frames_bad);
        v("messages_lost", m.messages_lost), v("items_repeated", m.items_repeated), v("starvations", m.starvations);
        v("override_percent", m.override_percent), v("map_crc", m.map_crc), v("key", m.key), v("source", m.source);
    }
};
enum StatusFlag : std::uint8_t {
    kFlagHomed = 1,
    kFlagEstopClosed = 2,
    kFlagInterlockClosed = 4,
    kFlagMasterOscillator = 8,
    kFlagGateOpen = 16,
    kFlagJobDone = 32,
    kFlagGuideLaser = 64,
    kFlagShutterOpen = 128,  ///< as it reads
};

struct ConfigChunk {
    static constexpr std::uint8_t kId = 69;
    static constexpr std::string_view kName = "config_chunk";
    std::uint16_t offset = 0;
    Bytes data;
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("offset", m.offset), v("data", m.data);
    }
};

/// What the distance sensors say: Y sensor, then the three of the triple head.
struct SensorReport {
    static constexpr std::uint8_t kId = 80;
    static constexpr std::uint8_t kSince = 1;
    static constexpr std::string_view kName = "sensor_report";
    std::uint64_t cell_time_us = 0;
    std::array<std::int32_t, 4> value{};  ///< the last good one; wire units
    std::array<std::uint32_t, 4> age_us{};
    std::array<std::uint8_t, 4> quality{};  ///< 0 none, 1 good, 2 repeated, 3 stale, 4 out of range, 5 faulty
    std::array<std::uint16_t, 4> code{};    ///< SensorCode, or Refusal::sensor_not_fitted; 0 = good
    std::array<std::uint8_t, 4> detail{};   ///< of the code
    std::array<std::uint32_t, 4> count{};   ///< measurements
    std::array<std::uint32_t, 4> repeats{};
    std::array<std::uint32_t, 4> bad{};       ///< telegrams that failed
    std::array<std::uint16_t, 4> last_bad{};  ///< why the last of them did
    std::uint8_t surface = 0;                 ///< 0 not watched, 1 waiting, 2 fine, 3 not seen, 4 off
    std::int32_t surface_depth = 0;           ///< y in h; wire units
    std::int32_t shift = 0;                   ///< of y, to follow it; wire units
    std::array<std::int32_t, 3> seating{};    ///< deviation of each in the last check of the seat; wire units
    template <class Visitor, class Self>
    static constexpr void visit(Visitor& v, Self& m) {
        v("cell_time_us", m.cell_time_us), v("value", m.value), v("age_us", m.age_us), v("quality", m.quality);
        v("code", m.code), v("detail", m.detail), v("count", m.count), v("repeats", m.repeats), v("bad", m.bad);
        v("last_bad", m.last_bad), v("surface", m.surface), v("surface_depth", m.surface_depth);
        v("shift", m.shift), v("seating", m.seating);
    }
};

}  // namespace sc::link
