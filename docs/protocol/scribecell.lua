-- SPDX-License-Identifier: Apache-2.0
-- scribecell's link 1.3 for Wireshark and tshark. Made by `scribecell protocol --write`; see docs/protocol.md.
-- tshark -X lua_script:scribecell.lua -r CAPTURE.pcap -V

local CAN_TO_HOST = 0x100 -- identifier of frames
local CAN_TO_CONTROLLER = 0x200 -- identifier of frames
local FIRST = 0x80 -- in the first byte of a frame
local LAST = 0x40 -- in the first byte of a frame
local SEQUENCE = 0x3f -- in the first byte of a frame
local OVERHEAD = 7 -- bytes of a message besides its payload
local LONGEST = 247 -- bytes of a message
local SEAL = 8 -- bytes behind the fields of a sealed message
local LONGEST_RUN = 224 -- bytes of a field of type bytes
local HELLO = 1 -- message that begins a new count
local HELLO_REPLY = 64 -- message that begins a new count
local HANDSHAKE_CRC = 0x64ca1c23 -- CRC-32 of the data id of these two

-- CRC-32 of each minor version's schema hash, which goes before the message.
local versions = {
    { minor = 3, crc = 0x6722b3ff }, -- schema 0xa469fb52f2f5805e
    { minor = 2, crc = 0xea785bf2 }, -- schema 0x0eb085b5844e0bc5
    { minor = 1, crc = 0x311ee865 }, -- schema 0xbfd3e071dc893732
    { minor = 0, crc = 0x8746cc85 }, -- schema 0x51d71a83279a0873
}

local messages = {
    [1] = { name = "hello", to_controller = true, fields = {
        { name = "schema", type = "u64", count = 1 },
        { name = "major", type = "u8", count = 1 },
        { name = "minor", type = "u8", count = 1 },
        { name = "session", type = "u32", count = 1 },
        { name = "heartbeat_timeout_ms", type = "u16", count = 1 },
    } },
    [2] = { name = "heartbeat", to_controller = true, fields = {
        { name = "host_time_us", type = "u64", count = 1 },
    } },
    [3] = { name = "command", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "verb", type = "u8", count = 1 },
        { name = "arg0", type = "i32", count = 1 },
        { name = "arg1", type = "i32", count = 1 },
        { name = "arg2", type = "i32", count = 1 },
    } },
    [4] = { name = "job_open", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "job", type = "u64", count = 1 },
        { name = "items", type = "u32", count = 1 },
    } },
    [5] = { name = "block", to_controller = true, fields = {
        { name = "job_low", type = "u32", count = 1 },
        { name = "first", type = "u32", count = 1 },
        { name = "count", type = "u8", count = 1 },
        { name = "items", type = "bytes", count = 1 },
    } },
    [6] = { name = "set_compensation", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "axis_matrix", type = "f64", count = 9 },
        { name = "axis_offset", type = "f64", count = 3 },
        { name = "galvo_matrix", type = "f64", count = 4 },
        { name = "galvo_offset", type = "f64", count = 2 },
    } },
    [7] = { name = "config_request", to_controller = true, fields = {
        { name = "offset", type = "u16", count = 1 },
    } },
    [8] = { name = "map_chunk", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "offset", type = "u16", count = 1 },
        { name = "data", type = "bytes", count = 1 },
    } },
    [9] = { name = "set_map", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "bytes", type = "u16", count = 1 },
        { name = "crc", type = "u32", count = 1 },
    } },
    [10] = { name = "set_galvo_field", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "first", type = "u16", count = 1 },
        { name = "count", type = "u8", count = 1 },
        { name = "numbers", type = "f64", count = 24 },
    } },
    [11] = { name = "set_power_curve", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "count", type = "u8", count = 1 },
        { name = "bytes", type = "u8", count = 17 },
        { name = "watts", type = "f64", count = 17 },
    } },
    [12] = { name = "job_resume", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "job", type = "u64", count = 1 },
        { name = "items", type = "u32", count = 1 },
        { name = "first", type = "u32", count = 1 },
        { name = "hash_before", type = "u64", count = 1 },
        { name = "c", type = "i32", count = 1 },
        { name = "path", type = "u32", count = 1 },
        { name = "pass", type = "u8", count = 1 },
        { name = "pulse", type = "u32", count = 1 },
    } },
    [13] = { name = "position_request", to_controller = true, fields = {
        { name = "token", type = "u32", count = 1 },
    } },
    [14] = { name = "set_galvo_lag", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "latency_ns", type = "u32", count = 1 },
        { name = "natural_frequency_hz", type = "f64", count = 1 },
        { name = "damping", type = "f64", count = 1 },
    } },
    [15] = { name = "telemetry_request", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "channels", type = "u32", count = 1 },
        { name = "period_ticks", type = "u16", count = 4 },
        { name = "line_bytes_per_s", type = "u32", count = 1 },
    } },
    [16] = { name = "blackbox_request", to_controller = true, fields = {
        { name = "part", type = "u8", count = 1 },
        { name = "first", type = "u32", count = 1 },
    } },
    [18] = { name = "store_parameters", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "layout", type = "u16", count = 1 },
        { name = "bytes", type = "u16", count = 1 },
        { name = "crc", type = "u32", count = 1 },
    } },
    [19] = { name = "parameters_request", to_controller = true, fields = {
        { name = "offset", type = "u16", count = 1 },
    } },
    [20] = { name = "set_surface", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "mode", type = "u8", count = 1 },
        { name = "origin", type = "f64", count = 3 },
        { name = "direction", type = "f64", count = 3 },
        { name = "zero", type = "f64", count = 1 },
        { name = "window", type = "f64", count = 1 },
        { name = "bound", type = "f64", count = 1 },
    } },
    [21] = { name = "check_seating", to_controller = true, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "expected", type = "i32", count = 3 },
        { name = "tolerance", type = "i32", count = 1 },
        { name = "tilt", type = "i32", count = 1 },
        { name = "samples", type = "u8", count = 1 },
    } },
    [22] = { name = "sensors_request", to_controller = true, fields = {
    } },
    [23] = { name = "seal_request", to_controller = true, fields = {
        { name = "session", type = "u32", count = 1 },
        { name = "nonce", type = "u8", count = 16 },
    } },
    [24] = { name = "seal_hello", to_controller = true, fields = {
        { name = "session", type = "u32", count = 1 },
        { name = "challenge", type = "u32", count = 1 },
        { name = "heartbeat_timeout_ms", type = "u16", count = 1 },
        { name = "first", type = "u16", count = 1 },
        { name = "proof", type = "u8", count = 8 },
    } },
    [64] = { name = "hello_reply", to_controller = false, fields = {
        { name = "schema", type = "u64", count = 1 },
        { name = "major", type = "u8", count = 1 },
        { name = "minor", type = "u8", count = 1 },
        { name = "refusal", type = "u16", count = 1 },
        { name = "session", type = "u32", count = 1 },
        { name = "boot", type = "u32", count = 1 },
        { name = "config_bytes", type = "u16", count = 1 },
        { name = "config_crc", type = "u32", count = 1 },
        { name = "last_sequence", type = "u32", count = 1 },
    } },
    [65] = { name = "command_reply", to_controller = false, fields = {
        { name = "sequence", type = "u32", count = 1 },
        { name = "refusal", type = "u16", count = 1 },
        { name = "detail", type = "i64", count = 1 },
    } },
    [66] = { name = "stream_ack", to_controller = false, fields = {
        { name = "job_low", type = "u32", count = 1 },
        { name = "received", type = "u32", count = 1 },
        { name = "planned", type = "u32", count = 1 },
        { name = "fired", type = "u32", count = 1 },
        { name = "free_items", type = "u16", count = 1 },
        { name = "path", type = "u32", count = 1 },
        { name = "pass", type = "u8", count = 1 },
        { name = "pulses", type = "u32", count = 1 },
    } },
    [67] = { name = "job_refused", to_controller = false, fields = {
        { name = "job_low", type = "u32", count = 1 },
        { name = "item", type = "u32", count = 1 },
        { name = "refusal", type = "u16", count = 1 },
        { name = "axis", type = "u8", count = 1 },
        { name = "value", type = "i64", count = 1 },
    } },
    [68] = { name = "status", to_controller = false, fields = {
        { name = "cell_time_us", type = "u64", count = 1 },
        { name = "state", type = "u8", count = 1 },
        { name = "faults", type = "u64", count = 1 },
        { name = "first_fault", type = "u8", count = 1 },
        { name = "first_fault_axis", type = "u8", count = 1 },
        { name = "limited_by", type = "u8", count = 1 },
        { name = "flags", type = "u8", count = 1 },
        { name = "actual", type = "i32", count = 4 },
        { name = "pulses_total", type = "u32", count = 1 },
        { name = "frames_bad", type = "u32", count = 1 },
        { name = "messages_lost", type = "u32", count = 1 },
        { name = "items_repeated", type = "u32", count = 1 },
        { name = "starvations", type = "u32", count = 1 },
        { name = "override_percent", type = "u8", count = 1 },
        { name = "map_crc", type = "u32", count = 1 },
        { name = "key", type = "u8", count = 1 },
        { name = "source", type = "u8", count = 1 },
    } },
    [69] = { name = "config_chunk", to_controller = false, fields = {
        { name = "offset", type = "u16", count = 1 },
        { name = "data", type = "bytes", count = 1 },
    } },
    [70] = { name = "position", to_controller = false, fields = {
        { name = "token", type = "u32", count = 1 },
        { name = "source", type = "u8", count = 1 },
        { name = "job", type = "u64", count = 1 },
        { name = "items", type = "u32", count = 1 },
        { name = "fired", type = "u32", count = 1 },
        { name = "path", type = "u32", count = 1 },
        { name = "pass", type = "u8", count = 1 },
        { name = "pulses", type = "u32", count = 1 },
        { name = "reached_path", type = "u32", count = 1 },
        { name = "reached_pass", type = "u8", count = 1 },
        { name = "reached_pulses", type = "u32", count = 1 },
    } },
    [71] = { name = "stream_missing", to_controller = false, fields = {
        { name = "job_low", type = "u32", count = 1 },
        { name = "heard", type = "u16", count = 1 },
        { name = "count", type = "u8", count = 1 },
        { name = "from", type = "u32", count = 4 },
        { name = "until", type = "u32", count = 4 },
    } },
    [72] = { name = "clock_reply", to_controller = false, fields = {
        { name = "host_time_us", type = "u64", count = 1 },
        { name = "received_us", type = "u64", count = 1 },
        { name = "sent_us", type = "u64", count = 1 },
    } },
    [73] = { name = "telemetry", to_controller = false, fields = {
        { name = "channels", type = "u32", count = 1 },
        { name = "cell_time_us", type = "u64", count = 1 },
        { name = "skipped", type = "u16", count = 1 },
        { name = "values", type = "bytes", count = 1 },
    } },
    [74] = { name = "blackbox_chunk", to_controller = false, fields = {
        { name = "part", type = "u8", count = 1 },
        { name = "first", type = "u32", count = 1 },
        { name = "begin", type = "u32", count = 1 },
        { name = "end", type = "u32", count = 1 },
        { name = "frozen", type = "u8", count = 1 },
        { name = "fault", type = "u8", count = 1 },
        { name = "axis", type = "u8", count = 1 },
        { name = "newest_us", type = "u64", count = 1 },
        { name = "period_ns", type = "u32", count = 1 },
        { name = "count", type = "u8", count = 1 },
        { name = "records", type = "u8", count = 210 },
    } },
    [79] = { name = "parameters", to_controller = false, fields = {
        { name = "fitted", type = "u8", count = 1 },
        { name = "in_force", type = "u8", count = 1 },
        { name = "generation", type = "u32", count = 1 },
        { name = "layout", type = "u16", count = 1 },
        { name = "bytes", type = "u16", count = 1 },
        { name = "crc", type = "u32", count = 1 },
        { name = "offset", type = "u16", count = 1 },
        { name = "count", type = "u8", count = 1 },
        { name = "data", type = "u8", count = 200 },
    } },
    [80] = { name = "sensor_report", to_controller = false, fields = {
        { name = "cell_time_us", type = "u64", count = 1 },
        { name = "value", type = "i32", count = 4 },
        { name = "age_us", type = "u32", count = 4 },
        { name = "quality", type = "u8", count = 4 },
        { name = "code", type = "u16", count = 4 },
        { name = "detail", type = "u8", count = 4 },
        { name = "count", type = "u32", count = 4 },
        { name = "repeats", type = "u32", count = 4 },
        { name = "bad", type = "u32", count = 4 },
        { name = "last_bad", type = "u16", count = 4 },
        { name = "surface", type = "u8", count = 1 },
        { name = "surface_depth", type = "i32", count = 1 },
        { name = "shift", type = "i32", count = 1 },
        { name = "seating", type = "i32", count = 3 },
    } },
    [81] = { name = "seal_challenge", to_controller = false, fields = {
        { name = "session", type = "u32", count = 1 },
        { name = "challenge", type = "u32", count = 1 },
        { name = "nonce", type = "u8", count = 16 },
        { name = "proof", type = "u8", count = 8 },
        { name = "blocks_per_s", type = "u32", count = 1 },
    } },
}

local link = Proto("scribecell", "scribecell link")
local link_can = Proto("scribecell_can", "scribecell link over CAN")
local link_serial = Proto("scribecell_serial", "scribecell link over a serial line")

local directions = { [0] = "to the host", [1] = "to the controller" }
local TO_HOST, TO_CONTROLLER = 0, 1

-- Fields ------------------------------------------------------------------------------------------------------------

local names = {}
for id, message in pairs(messages) do
    names[id] = message.name
end

local pf = {
    direction = ProtoField.uint8("scribecell.direction", "Direction", base.DEC, directions),
    id = ProtoField.uint8("scribecell.id", "Message", base.DEC, names),
    counter = ProtoField.uint16("scribecell.counter", "Counter", base.DEC),
    payload = ProtoField.bytes("scribecell.payload", "Payload"),
    crc = ProtoField.uint32("scribecell.crc", "Checksum", base.HEX),
    crc_good = ProtoField.bool("scribecell.crc_good", "Checksum is right"),
    minor = ProtoField.uint8("scribecell.minor", "Minor version of the schema", base.DEC),
    tag = ProtoField.bytes("scribecell.tag", "Seal"),
    lost = ProtoField.uint32("scribecell.lost", "Messages lost before", base.DEC),
    repeated = ProtoField.bool("scribecell.repeated", "Repeated or late"),
}
local pf_can = {
    first = ProtoField.bool("scribecell_can.first", "First of a message", 8, nil, FIRST),
    last = ProtoField.bool("scribecell_can.last", "Last of a message", 8, nil, LAST),
    sequence = ProtoField.uint8("scribecell_can.sequence", "Sequence", base.DEC, nil, SEQUENCE),
    length = ProtoField.uint8("scribecell_can.length", "Bytes of the message", base.DEC),
    data = ProtoField.bytes("scribecell_can.data", "Piece of a message"),
}
local pf_serial = { direction = ProtoField.uint8("scribecell_serial.direction", "Direction", base.DEC, directions) }

local notes = {
    crc = ProtoExpert.new("scribecell.note_crc", "Wrong checksum", expert.group.CHECKSUM, expert.severity.ERROR),
    lost = ProtoExpert.new("scribecell.note_lost", "Messages were lost", expert.group.SEQUENCE, expert.severity.WARN),
    repeated = ProtoExpert.new("scribecell.note_repeated", "Message came twice or late", expert.group.SEQUENCE,
        expert.severity.NOTE),
    malformed = ProtoExpert.new("scribecell.note_malformed", "Fields do not come out", expert.group.MALFORMED,
        expert.severity.ERROR),
    unknown = ProtoExpert.new("scribecell.note_unknown", "No message of this schema", expert.group.UNDECODED,
        expert.severity.WARN),
    spoilt = ProtoExpert.new("scribecell.note_spoilt", "Spoilt frame", expert.group.MALFORMED, expert.severity.WARN),
}
local notes_can = {
    gap = ProtoExpert.new("scribecell_can.gap", "Frames were lost", expert.group.SEQUENCE, expert.severity.WARN),
    dropped = ProtoExpert.new("scribecell_can.dropped", "Frame belongs to no whole message", expert.group.SEQUENCE,
        expert.severity.WARN),
    again = ProtoExpert.new("scribecell_can.again", "Frame came twice", expert.group.SEQUENCE, expert.severity.NOTE),
}

local number_fields = {
    u8 = { ProtoField.uint8, 1 }, u16 = { ProtoField.uint16, 2 }, u32 = { ProtoField.uint32, 4 },
    u64 = { ProtoField.uint64, 8 }, i8 = { ProtoField.int8, 1 }, i16 = { ProtoField.int16, 2 },
    i32 = { ProtoField.int32, 4 }, i64 = { ProtoField.int64, 8 }, f32 = { ProtoField.float, 4 },
    f64 = { ProtoField.double, 8 },
}

local all = {}
for _, field in pairs(pf) do
    all[#all + 1] = field
end
for _, message in pairs(messages) do
    for _, field in ipairs(message.fields) do
        local abbreviation = "scribecell." .. message.name .. "." .. field.name
        if field.type == "bytes" then
            field.size_proto = ProtoField.uint8(abbreviation .. ".size", field.name .. " size", base.DEC)
            field.proto = ProtoField.bytes(abbreviation, field.name)
            all[#all + 1] = field.size_proto
        else
            local make = number_fields[field.type]
            field.proto = make[1](abbreviation, field.name)
            field.size = make[2]
        end
        all[#all + 1] = field.proto
    end
end
link.fields = all
link.experts = notes
link_can.fields = pf_can
link_can.experts = notes_can
link_serial.fields = pf_serial
link.prefs.port = Pref.uint("TCP port", 7000, "Port of a cell (scribecell cell --tcp PORT)")

-- Checksum ----------------------------------------------------------------------------------------------------------

local bits = bit or bit32
local bxor, band, rshift = bits.bxor, bits.band, bits.rshift

local crc_table = {}
for i = 0, 255 do
    local value = i
    for _ = 1, 8 do
        value = band(value, 1) == 1 and bxor(rshift(value, 1), 0xedb88320) or rshift(value, 1)
    end
    crc_table[i] = value
end

-- CRC-32 of the bytes whose CRC-32 is `before`, and then of `text`.
local function crc32(before, text)
    local value = bxor(before, 0xffffffff)
    for i = 1, #text do
        value = bxor(rshift(value, 8), crc_table[band(bxor(value, text:byte(i)), 0xff)])
    end
    return bxor(value, 0xffffffff) % 0x100000000
end

-- The minor version whose schema the checksum of a message fits; nil for a wrong one.
local function checked(text)
    local at = #text - 3
    local told = text:byte(at) + text:byte(at + 1) * 0x100 + text:byte(at + 2) * 0x10000
        + text:byte(at + 3) * 0x1000000
    local covered = text:sub(1, at - 1)
    local id = text:byte(1)
    for _, version in ipairs(versions) do
        local handshake = id == HELLO or id == HELLO_REPLY
        if crc32(handshake and HANDSHAKE_CRC or version.crc, covered) == told then
            return version.minor
        end
    end
    return nil
end

-- State of a capture, from its beginning. A packet is looked at again and again, but counts once -------------------

local state = {}

local function forget()
    state = { counters = {}, verdicts = {}, can = {}, can_results = {}, carry = {}, carried = {} }
end
forget()
link.init = forget

-- What a message's counter says: { lost, repeated }. As in shared/link/counter.hpp.
local function count(stream, opens, counter)
    local last = state.counters[stream]
    if opens or last == nil then
        state.counters[stream] = counter
        return { lost = 0, repeated = false }
    end
    if (last - counter) % 0x10000 < 64 then
        return { lost = 0, repeated = true }
    end
    state.counters[stream] = counter
    return { lost = (counter - last - 1) % 0x10000, repeated = false }
end

-- Messages ----------------------------------------------------------------------------------------------------------

-- Adds the fields of a payload; false when they do not come out. A seal may stand behind what a host sends.
local function add_fields(message, tvb, tree)
    local at = 0
    for _, field in ipairs(message.fields) do
        if field.type == "bytes" then
            if at + 1 > tvb:len() then
                return false
            end
            local size = tvb(at, 1):uint()
            tree:add_le(field.size_proto, tvb(at, 1))
            at = at + 1
            if size > LONGEST_RUN or at + size > tvb:len() then
                return false
            end
            if size > 0 then
                tree:add(field.proto, tvb(at, size))
            end
            at = at + size
        else
            for i = 1, field.count do
                if at + field.size > tvb:len() then
                    return false
                end
                local item = tree:add_le(field.proto, tvb(at, field.size))
                if field.count > 1 then
                    item:prepend_text("[" .. (i - 1) .. "] ")
                end
                at = at + field.size
            end
        end
    end
    if message.to_controller and tvb:len() - at == SEAL then
        tree:add(pf.tag, tvb(at, SEAL))
        return true
    end
    return at == tvb:len()
end

local function whole_size(size)
    return size >= OVERHEAD and size <= LONGEST
end

-- One message. `stream`: what its counter belongs to. `place`: which message of the packet it is.
local function dissect_message(tvb, pinfo, root, direction, stream, place)
    local text = tvb:raw()
    local tree = root:add(link, tvb())
    tree:add(pf.direction, direction):set_generated()
    if not whole_size(tvb:len()) then
        tree:add_proto_expert_info(notes.spoilt)
        return
    end
    local id = tvb(0, 1):uint()
    local counter = tvb(1, 2):le_uint()
    local message = messages[id]
    if message and message.to_controller ~= (direction == TO_CONTROLLER) then
        message = nil
    end
    local name = message and message.name or ("unknown message " .. id)
    tree:append_text(", " .. name .. ", counter " .. counter)
    tree:add(pf.id, tvb(0, 1))
    tree:add_le(pf.counter, tvb(1, 2))
    local size = tvb:len() - OVERHEAD
    local minor = checked(text)
    if minor and message then
        local before = tree:add(pf.payload, tvb(3, size))
        local payload = size > 0 and tvb(3, size):tvb() or ByteArray.new():tvb("no payload")
        before:set_text(message.name)
        if not add_fields(message, payload, before) then
            tree:add_proto_expert_info(notes.malformed)
        end
    elseif size > 0 then
        tree:add(pf.payload, tvb(3, size))
        if minor then
            tree:add_proto_expert_info(notes.unknown)
        end
    end
    tree:add_le(pf.crc, tvb(3 + size, 4))
    tree:add(pf.crc_good, minor ~= nil):set_generated()
    if not minor then
        tree:add_proto_expert_info(notes.crc)
        pinfo.cols.info:append(" [wrong checksum]")
        return
    end
    tree:add(pf.minor, minor):set_generated()
    local key = pinfo.number .. "/" .. place
    if not pinfo.visited then
        local opens = id == (direction == TO_CONTROLLER and HELLO or HELLO_REPLY)
        state.verdicts[key] = count(stream, opens, counter)
    end
    local verdict = state.verdicts[key] or { lost = 0, repeated = false }
    tree:add(pf.lost, verdict.lost):set_generated()
    tree:add(pf.repeated, verdict.repeated):set_generated()
    if verdict.lost > 0 then
        tree:add_proto_expert_info(notes.lost)
    end
    if verdict.repeated then
        tree:add_proto_expert_info(notes.repeated)
    end
    pinfo.cols.info:append(" " .. name)
end

-- Serial: COBS frames, each ended by a zero ----------------------------------------------------------------------

-- The bytes that a frame (without its end) stands for; nil for one that was cut.
local function from_cobs(frame)
    local parts = {}
    local at = 1
    while at <= #frame do
        local code = frame:byte(at)
        if at + code - 1 > #frame then
            return nil
        end
        parts[#parts + 1] = frame:sub(at + 1, at + code - 1)
        at = at + code
        if code < 0xff and at <= #frame then
            parts[#parts + 1] = "\0"
        end
    end
    return table.concat(parts)
end

-- All whole frames of `text`; how many bytes they were.
local function dissect_serial(text, pinfo, tree, direction, stream, place)
    local at = 1
    while true do
        local stop = text:find("\0", at, true)
        if not stop then
            return at - 1
        end
        if stop > at then
            local whole = from_cobs(text:sub(at, stop - 1))
            local good = whole ~= nil and #whole > 0
            if good then
                local tvb = ByteArray.new(whole, true):tvb("Message")
                dissect_message(tvb, pinfo, tree, direction, stream, place .. "/" .. at)
            else
                tree:add(link):add_proto_expert_info(notes.spoilt)
            end
        end
        at = stop + 1
    end
end

-- TCP. The cell's end is the one with the port of the preferences.
function link.dissector(tvb, pinfo, tree)
    pinfo.cols.protocol = "scribecell"
    pinfo.cols.info:clear()
    local direction = pinfo.dst_port == link.prefs.port and TO_CONTROLLER or TO_HOST
    local stream = table.concat({ tostring(pinfo.src), pinfo.src_port, tostring(pinfo.dst), pinfo.dst_port }, " ")
    local used = dissect_serial(tvb:raw(), pinfo, tree, direction, stream, "tcp" .. tvb:len())
    if used < tvb:len() then
        pinfo.desegment_offset = used
        pinfo.desegment_len = DESEGMENT_ONE_MORE_SEGMENT
    end
end

-- A byte of direction, then bytes as they came; a frame may go on in the direction's next packet.
function link_serial.dissector(tvb, pinfo, tree)
    pinfo.cols.protocol = "scribecell"
    pinfo.cols.info:clear()
    local direction = tvb(0, 1):uint()
    tree:add(link_serial, tvb()):add(pf_serial.direction, tvb(0, 1))
    if not pinfo.visited then
        state.carried[pinfo.number] = state.carry[direction] or ""
    end
    local before = state.carried[pinfo.number] or ""
    local text = before .. tvb:raw(1)
    local used = dissect_serial(text, pinfo, tree, direction, "serial " .. direction, "serial")
    if not pinfo.visited then
        state.carry[direction] = text:sub(used + 1)
    end
end

-- CAN: as in shared/link/can_framing.cpp ---------------------------------------------------------------------------

local function drop(s, result)
    if s.mode ~= "skipping" then
        result.dropped = true
    end
    s.mode = "skipping"
end

-- Takes a frame; what came of it: message (text), gap, dropped, again.
local function reassemble(s, text, may_pad)
    local result = {}
    local head = text:byte(1)
    if s.last_head == head then
        result.again = true
        return result
    end
    if s.last_head and (s.last_head + 1) % (SEQUENCE + 1) ~= head % (SEQUENCE + 1) then
        result.gap = true
        drop(s, result)
    end
    s.last_head = head
    local body = text:sub(2)
    if band(head, FIRST) ~= 0 then
        if s.mode == "inside" then
            drop(s, result)
        end
        local length = body:byte(1)
        if not length or length == 0 or length > LONGEST then
            drop(s, result)
            return result
        end
        s.expected, s.message, s.mode = length, "", "inside"
        body = body:sub(2)
    elseif s.mode ~= "inside" then
        drop(s, result)
        return result
    end
    local wanted = s.expected - #s.message
    local last = band(head, LAST) ~= 0
    local fits
    if last then
        fits = #body == wanted or (may_pad and #body > wanted)
    else
        fits = #body < wanted
    end
    if not fits then
        drop(s, result)
        return result
    end
    s.message = s.message .. body:sub(1, wanted)
    if last then
        s.mode = "idle"
        result.message = s.message
    end
    return result
end

local function dissect_can(tvb, pinfo, root, direction)
    pinfo.cols.protocol = "scribecell"
    pinfo.cols.info:clear()
    local tree = root:add(link_can, tvb())
    if tvb:len() == 0 then
        return 0
    end
    tree:add(pf_can.first, tvb(0, 1))
    tree:add(pf_can.last, tvb(0, 1))
    tree:add(pf_can.sequence, tvb(0, 1))
    local at = 1
    if band(tvb(0, 1):uint(), FIRST) ~= 0 and tvb:len() > 1 then
        tree:add(pf_can.length, tvb(1, 1))
        at = 2
    end
    if tvb:len() > at then
        tree:add(pf_can.data, tvb(at))
    end
    if not pinfo.visited then
        state.can[direction] = state.can[direction] or { mode = "idle" }
        state.can_results[pinfo.number] = reassemble(state.can[direction], tvb:raw(), tvb:len() > 8)
    end
    local result = state.can_results[pinfo.number] or {}
    for what, info in pairs(notes_can) do
        if result[what] then
            tree:add_proto_expert_info(info)
        end
    end
    if result.message then
        local whole = ByteArray.new(result.message, true):tvb("Message")
        dissect_message(whole, pinfo, root, direction, "can " .. direction, "can")
    else
        pinfo.cols.info:append(" piece of a message")
    end
    return tvb:len()
end

local to_host = Proto("scribecell_to_host", "scribecell link over CAN, to the host")
local to_controller = Proto("scribecell_to_controller", "scribecell link over CAN, to the controller")
function to_host.dissector(tvb, pinfo, tree)
    return dissect_can(tvb, pinfo, tree, TO_HOST)
end
function to_controller.dissector(tvb, pinfo, tree)
    return dissect_can(tvb, pinfo, tree, TO_CONTROLLER)
end

-- Where they are found ----------------------------------------------------------------------------------------------

DissectorTable.get("can.id"):add(CAN_TO_HOST, to_host)
DissectorTable.get("can.id"):add(CAN_TO_CONTROLLER, to_controller)
DissectorTable.get("wtap_encap"):add(wtap.USER0, link_serial)

local tcp_port = DissectorTable.get("tcp.port")
local port_in_use = link.prefs.port
tcp_port:add(port_in_use, link)
function link.prefs_changed()
    tcp_port:remove(port_in_use, link)
    port_in_use = link.prefs.port
    tcp_port:add(port_in_use, link)
end
