// SPDX-License-Identifier: Apache-2.0
#include "host/protocol/dissector.hpp"

namespace sc::host {
namespace {

constexpr const char* kRuntime = R"LUA(
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
)LUA";

}  // namespace

const char* dissector_runtime() noexcept { return kRuntime; }

}  // namespace sc::host
