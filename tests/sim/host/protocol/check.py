# SPDX-License-Identifier: Apache-2.0
"""The files of docs/protocol against captures: every field of every message as tshark with our dissector and canmatrix
with our DBC files read it must be what scribecell's own decoder reads; a broken copy of either must be found.

usage: check.py SCRIBECELL SAMPLE-PROGRAM PROTOCOL-FOLDER WORK-FOLDER serial|can|canfd"""
import json
import pathlib
import random
import re
import shutil
import struct
import subprocess
import sys

import captures

LEAST_MESSAGES = 200  # of the real job: fewer would be no job


def fail_unless(condition, text):
    if not condition:
        raise SystemExit("FAILED: " + text)


def compare(decoded, folder, capture, carrier):
    found = captures.compare_tshark(decoded, str(folder / "scribecell.lua"), str(capture))
    if carrier != "serial":
        found += captures.compare_dbc(decoded, str(folder), str(capture), carrier == "canfd")
    return found


def check(scribecell, folder, capture, carrier):
    decoded = captures.ours(scribecell, str(capture))
    found = compare(decoded, folder, capture, carrier)
    fail_unless(not found, f"{capture.name}:\n" + "\n".join(found))
    names = {m["name"] for m in decoded["messages"]}
    fields = sum(len(v) if isinstance(v, list) else 1 for m in decoded["messages"] for v in m["fields"].values())
    print(f"{capture.name}: {len(decoded['messages'])} messages of {len(names)} kinds, {fields} values: no difference")
    return decoded


def all_names(folder):
    text = (folder / "scribecell_messages.dbc").read_text()
    return set(re.findall(r"^BO_ \d+ (\w+):", text, re.MULTILINE))


def check_losses(decoded):
    """The troubles of the sample show in what our decoder counts."""
    total = {key: sum(decoded[d][key] for d in (captures.TO_HOST, captures.TO_CONTROLLER))
             for key in decoded["to_host"]}
    wanted = ["checks_failed", "gaps", "messages_dropped", "frames_repeated"] if decoded["kind"] == "can" else [
        "frames_bad"]
    fail_unless(all(total[key] > 0 for key in wanted), f"the sample's troubles were not seen: {total}")
    for key in ("lost", "repeated"):
        fail_unless(any(m[key] for m in decoded["messages"]), f"no message is {key} in the sample")


# --- broken copies --------------------------------------------------------------------------------------------------

def broken(folder, work, file, old, new):
    copy = work / ("broken_" + file)
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(folder, copy)
    text = (copy / file).read_text()
    fail_unless(len(re.findall(old, text)) >= 1, f"{file} has no {old} to break")
    (copy / file).write_text(re.sub(old, new, text, count=1))
    return copy


def check_breaks(decoded, folder, work, capture, carrier):
    breaks = [
        # A field of another size moves all behind it; another sign changes its value alone.
        ("scribecell.lua", r'"free_items", type = "u16"', '"free_items", type = "u32"'),
        ("scribecell.lua", r'"actual", type = "i32"', '"actual", type = "u32"'),
        ("scribecell.lua", r'\{ minor = 1, crc = 0x.', '{ minor = 1, crc = 0x0'),
        ("scribecell.lua", r'local size = tvb\(at, 1\):uint\(\)', 'local size = tvb(at, 1):uint() - 1'),
        ("scribecell.lua", r'last - counter', 'last + 1 - counter'),
    ]
    if carrier != "serial":
        breaks += [
            ("scribecell_messages.dbc", r"SG_ free_items : (\d+)\|16", r"SG_ free_items : 8|16"),
            ("scribecell_messages.dbc", r"SG_ actual_3 : (\d+)\|32@1-", r"SG_ actual_3 : \1|32@1+"),
            ("scribecell_messages.dbc", r"(SG_MUL_VAL_ \d+ items_9 items_size) 10-", r"\1 200-"),
            ("scribecell.lua", r"local LAST = 0x40", "local LAST = 0x20"),
        ]
    if carrier == "can":
        breaks += [
            ("scribecell.dbc", r"SG_ sequence : 0\|6", "SG_ sequence : 0|5"),
            ("scribecell.dbc", r"SG_ m69_offset m69 : 40\|16", "SG_ m69_offset m69 : 48|16"),
        ]
    for file, old, new in breaks:
        copy = broken(folder, work, file, old, new)
        found = compare(decoded, copy, capture, carrier)
        fail_unless(found, f"{file} with {new} in place of {old} was not found out")
    print(f"{len(breaks)} broken copies found out")


# --- TCP ------------------------------------------------------------------------------------------------------------

def tcp_packet(to_cell, sequence, acknowledge, data):
    ports = (50000, 7000) if to_cell else (7000, 50000)
    tcp = struct.pack(">HHIIBBHHH", *ports, sequence, acknowledge, 5 << 4, 0x18, 65535, 0, 0) + data
    ends = (b"\x7f\0\0\1", b"\x7f\0\0\2")
    addresses = ends[0] + ends[1] if to_cell else ends[1] + ends[0]
    head = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(tcp), 0, 0, 64, 6, 0) + addresses
    return head + tcp


def write_tcp(serial, file, seed):
    """The bytes of a serial capture as a TCP connection, cut anywhere. The last bytes of each direction come last."""
    chance = random.Random(seed)
    ways = {0: bytearray(), 1: bytearray()}
    numbers = {0: 1, 1: 1}
    packets = []

    def send(way, size):
        data, ways[way][:] = bytes(ways[way][:size]), ways[way][size:]
        packets.append(tcp_packet(way == 1, numbers[way], numbers[1 - way], data))
        numbers[way] += len(data)

    for packet in captures.packets_of(serial):
        way = packet[0]
        ways[way] += packet[1:]
        while len(ways[way]) > chance.randint(0, 600):
            send(way, chance.randint(1, min(400, len(ways[way]))))
    for way in (0, 1):
        while ways[way]:
            send(way, 300)
    with open(file, "wb") as out:
        out.write(struct.pack("<IHHIIII", 0xa1b2c3d4, 2, 4, 0, 0, 262144, 101))
        for number, packet in enumerate(packets):
            out.write(struct.pack("<IIII", number // 1000, number % 1000 * 1000, len(packet), len(packet)) + packet)


def by_direction(messages):
    return [m for d in (captures.TO_HOST, captures.TO_CONTROLLER) for m in messages if m["direction"] == d]


def check_tcp(decoded, folder, serial, work):
    file = work / "tcp.pcap"
    write_tcp(serial, file, 3)
    lua = str(folder / "scribecell.lua")
    messages, _ = captures.tshark(lua, str(file))
    good = by_direction([m for m in messages if m["good"]])
    mine = by_direction(decoded["messages"])
    fail_unless(len(good) == len(mine), f"{len(good)} messages over TCP, {len(mine)} over the serial line")
    for one, seen in zip(mine, good):
        same = all(one[key] == seen[key] for key in ("direction", "id", "counter", "lost", "repeated"))
        same = same and not any(captures.field_differs(n, v, seen["fields"]) for n, v in one["fields"].items())
        fail_unless(same, f"over TCP {one['name']} {one['counter']} is {seen}")
    print(f"tcp: the same {len(mine)} messages, cut anywhere")


def burn(scribecell, link, *options):
    """A real job; the hash over its commands."""
    done = subprocess.run([scribecell, "scribe", "--face", "0", "--json", "--link", link, *options], check=True,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    return json.loads(done.stdout)["command_trace_sha256"]


def main():
    scribecell, sample, folder, work, carrier = sys.argv[1:]
    folder, work = pathlib.Path(folder), pathlib.Path(work) / carrier
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    subprocess.run([sample, work / "sample.pcap", carrier], check=True)
    decoded = check(scribecell, folder, work / "sample.pcap", carrier)
    missing = all_names(folder) - {m["name"] for m in decoded["messages"]}
    fail_unless(not missing, f"the sample lacks {missing}")
    check_losses(decoded)
    check_breaks(decoded, folder, work, work / "sample.pcap", carrier)
    if carrier == "serial":
        check_tcp(decoded, folder, work / "sample.pcap", work)
    fail_unless(burn(scribecell, f"sim:?carrier={carrier}", "--capture", work / "job.pcap") == burn(scribecell, "sim:"),
                "the carrier has changed the commands")
    job = check(scribecell, folder, work / "job.pcap", carrier)
    fail_unless(len(job["messages"]) >= LEAST_MESSAGES, f"the job has {len(job['messages'])} messages only")
    clean = all(n == 0 for d in (captures.TO_HOST, captures.TO_CONTROLLER) for n in job[d].values())
    fail_unless(clean and not any(m["lost"] for m in job["messages"]), "the job's capture has losses")
    if carrier == "serial":
        check_tcp(job, folder, work / "job.pcap", work)


if __name__ == "__main__":
    main()
