# SPDX-License-Identifier: Apache-2.0
"""Captures of the link decoded three ways: by scribecell, by tshark with our Lua, by canmatrix with our DBC files.
The last two share no code with the first. What differs is told, one line each."""
import json
import os
import struct
import subprocess
import xml.etree.ElementTree as ElementTree

TO_HOST, TO_CONTROLLER = "to_host", "to_controller"
DIRECTIONS = {0x100: TO_HOST, 0x200: TO_CONTROLLER}
LIMIT = 20  # of lines told


def ours(scribecell, capture):
    done = subprocess.run([scribecell, "protocol", "--decode", capture, "--json"], check=True, capture_output=True)
    return json.loads(done.stdout)


# --- tshark ---------------------------------------------------------------------------------------------------------

def values_of(tree):
    """Fields of a message below its tree: name to list of (shown text, bytes)."""
    found = {}
    for field in tree.iter("field"):
        name = field.get("name", "")
        if name.startswith("scribecell.") and name.count(".") >= 2:
            found.setdefault(name.split(".", 2)[2], []).append(
                (field.get("show"), bytes.fromhex(field.get("value") or "")))
    return found


def seen_message(proto):
    plain = {field.get("name"): field.get("show") for field in proto.iter("field")}
    experts = plain.keys() & {"scribecell.note_malformed", "scribecell.note_unknown", "scribecell.note_spoilt"}
    message = {"direction": (TO_HOST, TO_CONTROLLER)[int(plain.get("scribecell.direction", "0"))],
               "good": plain.get("scribecell.crc_good") == "1", "experts": experts}
    if message["good"]:
        message.update(id=int(plain["scribecell.id"]), counter=int(plain["scribecell.counter"]),
                       minor=int(plain["scribecell.minor"]), lost=int(plain["scribecell.lost"]),
                       repeated=plain["scribecell.repeated"] == "1",
                       tag=plain.get("scribecell.tag", "").replace(":", ""), fields=values_of(proto))
    return message


def tshark(lua, capture, *options):
    """Messages as Wireshark shows them, and how often each note on CAN frames stood."""
    command = ["tshark", "-r", capture, "-X", "lua_script:" + lua, "-T", "pdml", *options]
    environment = dict(os.environ, LC_ALL="C.UTF-8")
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment) as program:
        messages, notes, packet = [], {}, 0
        for _, element in ElementTree.iterparse(program.stdout):
            if element.tag != "packet":
                continue
            packet += 1
            for proto in element.findall("proto"):
                if proto.get("name") == "scribecell":
                    messages.append(dict(seen_message(proto), packet=packet))
                for field in proto.iter("field"):
                    name = field.get("name", "")
                    if name in ("scribecell_can.gap", "scribecell_can.dropped", "scribecell_can.again"):
                        notes[name] = notes.get(name, 0) + 1
            element.clear()
        errors = program.stderr.read().decode()
    if program.returncode != 0 or "Lua" in errors:
        raise SystemExit(f"tshark ended with {program.returncode}: {errors}")
    return messages, notes


def same_number(value, shown, raw):
    """A number of ours against what Wireshark shows and the bytes that it points to."""
    if isinstance(value, float):
        return float(shown) == float(f"{value:.15g}") and struct.pack("<d", value) == raw
    return int(shown, 0) == value and int.from_bytes(raw, "little", signed=value < 0) == value


def field_differs(name, value, seen):
    if isinstance(value, str):  # a run of bytes
        size = seen.get(name + ".size", [(None, b"")])[0][0]
        raw = seen.get(name, [("", b"")])[0][1]
        return size != str(len(value) // 2) or raw.hex() != value
    wanted = value if isinstance(value, list) else [value]
    found = seen.get(name, [])
    return len(found) != len(wanted) or not all(same_number(w, *f) for w, f in zip(wanted, found))


def compare_tshark(decoded, lua, capture, *options, packets=True):
    """`packets`: whether messages must end in the same packets."""
    messages, notes = tshark(lua, capture, *options)
    good = [m for m in messages if m["good"]]
    found = []
    if len(good) != len(decoded["messages"]):
        found.append(f"{len(good)} messages by tshark, {len(decoded['messages'])} by scribecell")
    heads = ["direction", "id", "counter", "minor", "lost", "repeated", "tag"] + (["packet"] if packets else [])
    for mine, seen in zip(decoded["messages"], good):
        where = f"packet {mine['packet']}, {mine['name']}"
        found += [f"{where}: {key} {mine[key]}, tshark {seen[key]}" for key in heads if mine[key] != seen[key]]
        found += [f"{where}: {name} = {value}, tshark {[s[0] for s in seen['fields'].get(name, [])]}"
                  for name, value in mine["fields"].items() if field_differs(name, value, seen["fields"])]
        known = {n for name in mine["fields"] for n in (name, name + ".size")}
        found += [f"{where}: tshark has {n} as well" for n in seen["fields"] if n not in known]
        if seen["experts"]:
            found.append(f"{where}: tshark says {seen['experts']}")
        if len(found) > LIMIT:
            break
    bad = [m for m in messages if not m["good"]]
    for direction in (TO_HOST, TO_CONTROLLER):
        mine = decoded[direction]["frames_bad"] + decoded[direction]["checks_failed"]
        theirs = sum(m["direction"] == direction or "direction" not in m for m in bad)
        if decoded["kind"] == "can" and mine != theirs:
            found.append(f"{direction}: {mine} spoilt by scribecell, {theirs} by tshark")
    if decoded["kind"] == "serial":
        mine = sum(decoded[d]["frames_bad"] + decoded[d]["checks_failed"] for d in (TO_HOST, TO_CONTROLLER))
        if mine != len(bad):
            found.append(f"{mine} spoilt by scribecell, {len(bad)} by tshark")
    for key, note in (("gaps", "gap"), ("frames_repeated", "again")):
        mine = sum(decoded[d][key] for d in (TO_HOST, TO_CONTROLLER))
        if mine != notes.get("scribecell_can." + note, 0):
            found.append(f"{mine} {key} by scribecell, {notes.get('scribecell_can.' + note, 0)} by tshark")
    return found


# --- canmatrix ------------------------------------------------------------------------------------------------------

def packets_of(capture):
    with open(capture, "rb") as file:
        data = file.read()
    at = 24
    while at < len(data):
        size = struct.unpack_from("<I", data, at + 8)[0]
        yield data[at + 16:at + 16 + size]
        at += 16 + size


def put_together(heads):
    """Whole messages from frames whose heads are known: (number of the frame, direction, bytes)."""
    begun = {}
    for number, direction, head, body in heads:
        state = begun.setdefault(direction, {})
        if state.get("head") == head:
            continue
        follows = "head" not in state or (state["head"][2] + 1) % 64 == head[2]
        state["head"] = head
        if not follows:
            state.pop("length", None)
        first, last, _, length = head
        if first:
            state.update(length=length, bytes=b"")
        elif "length" not in state:
            continue
        state["bytes"] += body
        if last:
            wanted = state.pop("length")
            if len(state["bytes"]) >= wanted:
                yield number, direction, state["bytes"][:wanted]


def frame_by_dbc(database, canmatrix, identifier, data, first_fields):
    """(first, last, sequence, length) and the piece of the message, as the DBC file of frames says."""
    signals = database.decode(canmatrix.ArbitrationId(identifier), data.ljust(8, b"\0"))
    raw = {name: signal.raw_value for name, signal in signals.items()}
    if raw["first"] == 1:
        first_fields.append(raw)
    return raw["first"], raw["last"], raw["sequence"], raw.get("length")


def frame_by_hand(data):
    return data[0] >> 7, data[0] >> 6 & 1, data[0] & 63, data[1] if data[0] >> 7 else None


def message_fields(frame, whole):
    """Fields of a message by its DBC frame: arrays and runs of bytes gathered."""
    signals = frame.decode(whole.ljust(frame.size, b"\0"))
    return {name: signal.raw_value for name, signal in signals.items()}


def differs(mine, raw):
    found = []
    for name, value in mine["fields"].items():
        if isinstance(value, str):
            size = raw.get(name + "_size")
            there = bytes(raw.get(f"{name}_{i}", 0) for i in range(size or 0)).hex()
            more = f"{name}_{size}" in raw
            seen, same = there, size == len(value) // 2 and there == value and not more
        elif isinstance(value, list):
            seen = [raw.get(f"{name}_{i}") for i in range(len(value))]
            same = seen == value and f"{name}_{len(value)}" not in raw
        else:
            seen = raw.get(name)
            same = seen == value
        if not same:
            found.append(f"{name} = {value}, DBC {seen}")
    return found


def first_frame_differs(mine, raw):
    """The fields that the first classic frame shows already, against the whole message's."""
    found = [] if (raw["message"], raw["counter"]) == (mine["id"], mine["counter"]) else ["message or counter"]
    for name, value in raw.items():
        if not name.startswith(f"m{mine['id']}_"):
            if name.startswith("m") and name[1:2].isdigit():
                found.append(f"{name} shown in a {mine['name']}")
            continue
        field = name.split("_", 1)[1]
        wanted = mine["fields"].get(field)
        if field.endswith("_size"):
            wanted = len(mine["fields"][field[:-5]]) // 2
        elif field not in mine["fields"]:
            start, index = field.rsplit("_", 1)
            wanted = mine["fields"][start][int(index)]
        if wanted != value:
            found.append(f"{field} = {wanted}, DBC of frames {value}")
    return found


def compare_dbc(decoded, folder, capture, fd):
    import canmatrix.canmatrix as canmatrix  # pylint: disable=import-outside-toplevel
    from canmatrix import formats  # pylint: disable=import-outside-toplevel
    frames = formats.loadp_flat(os.path.join(folder, "scribecell.dbc"))
    messages = formats.loadp_flat(os.path.join(folder, "scribecell_messages.dbc"))
    first_fields, heads, latest, firsts, by_packet = [], [], {}, {}, {}
    for number, packet in enumerate(packets_of(capture), 1):
        identifier = struct.unpack(">I", packet[:4])[0]
        direction, data = DIRECTIONS[identifier], packet[8:8 + packet[4]]
        head = frame_by_hand(data) if fd else frame_by_dbc(frames, canmatrix, identifier, data, first_fields)
        if head[0] and not fd:
            latest[direction] = first_fields[-1]
        firsts[number] = latest.get(direction)
        heads.append((number, direction, head, data[2 if head[0] else 1:]))
    for number, direction, whole in put_together(heads):
        by_packet[number] = (direction, whole)
    found = []
    for mine in decoded["messages"]:
        where = f"packet {mine['packet']}, {mine['name']}"
        if mine["packet"] not in by_packet:
            found.append(f"{where}: no whole message by the DBC of frames")
            continue
        direction, whole = by_packet.pop(mine["packet"])
        number = (0x200 if direction == TO_CONTROLLER else 0x100) * 256 + whole[0]
        frame = messages.frame_by_id(canmatrix.ArbitrationId(number, extended=True))
        if frame is None or frame.name != mine["name"]:
            found.append(f"{where}: the DBC of messages has {frame.name if frame else 'none'}")
            continue
        raw = message_fields(frame, whole)
        head = {"message_id": mine["id"], "message_counter": mine["counter"]}
        found += [f"{where}: {key} = {value}, DBC {raw.get(key)}" for key, value in head.items()
                  if raw.get(key) != value]
        found += [f"{where}: {text}" for text in differs(mine, raw)]
        if "message_crc" in raw and raw["message_crc"] != int.from_bytes(whole[-4:], "little"):
            found.append(f"{where}: the checksum lies elsewhere")
        if not fd:
            found += [f"{where}: {text}" for text in first_frame_differs(mine, firsts[mine["packet"]])]
        if len(found) > LIMIT:
            break
    spoilt = sum(decoded[d]["checks_failed"] for d in (TO_HOST, TO_CONTROLLER))
    if not found and len(by_packet) != spoilt:
        found.append(f"{len(by_packet)} whole frames are no messages of ours; {spoilt} had a wrong checksum")
    return found
