# SPDX-License-Identifier: Apache-2.0
"""Ethernet frames, changed at random, sent to the byte side of the port's receiver; against a model that takes them apart with scapy.

    net_frames.py PROGRAM

PROGRAM is net_receiver. For each frame the model says whether it is accepted, refused, damaged or nothing, what of it comes out, and what is
answered, as rtl/INTERFACE.md has it. HAPTOGRAM_NET_FRAMES is how many, 40,000 unless set; HAPTOGRAM_SEED of what. Exit code 1 with the first
frame that the receiver takes for something else.
"""
import os
import random
import struct
import subprocess
import sys
import zlib
from collections import Counter

from scapy.layers.inet import ICMP, IP, UDP, in4_chksum
from scapy.layers.l2 import ARP, Dot1Q, Ether
from scapy.packet import Raw
from scapy.utils import checksum, mac2str

MAC, ADDRESS, PORT = "02:48:47:00:00:01", "169.254.72.71", 4807
HOST, STRANGER = ("02:00:5e:10:20:30", "169.254.1.2", 51111), ("02:00:5e:09:09:09", "169.254.9.9", 40000)
ALL = "ff:ff:ff:ff:ff:ff"
PREAMBLE = bytes([0x55] * 7 + [0xD5])
IDENTIFY, DISABLE, STOP = 1, 5, 9
ARP_KIND, ICMP_KIND, ABOUT_KIND, ABOUT_LENGTH = 0, 1, 3, 104  # rtl/net/answers.vh
BATCH = 20000  # frames from one reset to the next
ACCEPTED, REFUSED, DAMAGED, DISABLES, STOPS, ANSWERS = (1 << bit for bit in range(6))
PEER_CLOCKS = 200000
NOTHING = (0, 0, 0, 0, 0, b"")


# ---- The model


class Model:
    def __init__(self):
        self.peer = None

    def judge(self, piece, error):
        """(flags, kind, length and sum of the answer, what was asked, the datagram) of a piece of what a PHY receives."""
        start = next((k for k, byte in enumerate(piece) if byte != 0x55), len(piece))
        if start == 0 or start == len(piece) or piece[start] != 0xD5 or error == start:
            return NOTHING
        frame = piece[start + 1 :]
        whole = 64 <= len(frame) <= 1518 and zlib.crc32(frame[:-4]) == int.from_bytes(frame[-4:], "little")
        if not whole or start < error < len(piece):
            return (DAMAGED, *NOTHING[1:])
        mine, everybody = frame[:6] == mac2str(MAC), frame[:6] == mac2str(ALL)
        if not (mine or everybody):
            return NOTHING
        ether = Ether(frame[:-4])
        arp, ip = ether.getlayer(ARP), ether.getlayer(IP)
        if isinstance(ether.payload, ARP) and (arp.hwtype, arp.ptype, arp.hwlen, arp.plen, arp.op) == (1, 0x0800, 6, 4, 1):
            return (ANSWERS, ARP_KIND, 42, None, None, b"") if arp.pdst == ADDRESS else NOTHING
        if not isinstance(ether.payload, IP) or not self.is_taken(ip, frame):
            return NOTHING
        here, message, header_good = mine and ip.dst == ADDRESS, frame[34 : 14 + ip.len], checksum(frame[14:34]) == 0
        if header_good and here and ip.proto == 1 and message[:2] == b"\x08\x00":
            total = int.from_bytes(message[2:4], "big") + 0x0800
            return (ANSWERS, ICMP_KIND, 14 + ip.len, (total & 0xFFFF) + (total >> 16), None, b"")
        if ip.proto != 17:
            return NOTHING
        udp = ip.payload
        if udp.len != len(message):
            return NOTHING
        if not header_good or (udp.chksum != 0 and in4_chksum(17, ip, message) != 0):
            return (DAMAGED, *NOTHING[1:]) if here and udp.dport == PORT else NOTHING
        if udp.dport == PORT + 1:
            return self.asked(message[8:], mine, here or everybody)
        return self.spoken((ether.src, ip.src, udp.sport), message[8:]) if here and udp.dport == PORT else NOTHING

    @staticmethod
    def is_taken(ip, frame):
        """Whether it is a whole datagram of version 4 without options, and no fragment, whatever its sum says."""
        return (
            (ip.version, ip.ihl, ip.frag) == (4, 5, 0)
            and int(ip.flags) in (0, 2)
            and 28 <= ip.len <= len(frame) - 18
        )

    def asked(self, payload, mine, may):
        if len(payload) != 4 or payload[:2] != b"HG" or payload[3] != 0 or not may:
            return NOTHING
        command = payload[2]
        if command != IDENTIFY and not (mine and command in (DISABLE, STOP)):
            return NOTHING
        return (ANSWERS | {DISABLE: DISABLES, STOP: STOPS}.get(command, 0), ABOUT_KIND, ABOUT_LENGTH, None, command, b"")

    def spoken(self, sender, payload):
        if self.peer not in (None, sender):
            return (REFUSED, *NOTHING[1:])
        self.peer = sender
        return (ACCEPTED, 0, 0, 0, 0, payload + b"\0" if payload and payload[-1] else payload)  # a frame ends with its datagram


# ---- Frames


def udp(sender, payload, port=PORT, mac=MAC, address=ADDRESS, **fields):
    return Ether(src=sender[0], dst=mac) / IP(src=sender[1], dst=address, **fields) / UDP(sport=sender[2], dport=port) / Raw(payload)


def seeds():
    """Good frames of every kind, and some of what others say on a network; without their FCS."""
    ping = Ether(src=HOST[0], dst=MAC) / IP(src=HOST[1], dst=ADDRESS) / ICMP(id=5, seq=1)
    arp = ARP(hwsrc=HOST[0], psrc=HOST[1], pdst=ADDRESS)
    frames = [udp(HOST, bytes(range(size))) for size in (0, 1, 2, 17, 18, 19, 60, 61, 208)] * 4
    frames += [udp(HOST, bytes(1472)), udp(STRANGER, b"other"), udp(STRANGER, b"other", 9), udp(HOST, b"zero", chksum=0)]
    frames += [udp(sender, b"HG" + bytes([command, 0]), PORT + 1) for sender in (HOST, STRANGER) for command in (0, 1, 5, 9)]
    frames += [udp(HOST, b"HG" + bytes([command, 0]), PORT + 1, ALL, "255.255.255.255") for command in (1, 5, 9)]
    frames += [udp(HOST, b"part", flags="MF"), udp(HOST, b"part", frag=3), udp(HOST, b"may not be parted", flags="DF"), udp(HOST, b"tos", tos=0xB8)]
    frames += [udp(HOST, b"elsewhere", address="169.254.9.1"), udp(HOST, b"to all", mac=ALL, address="169.254.255.255")]
    frames += [ping, ping / Raw(bytes(40)), ping / Raw(bytes(1472)), Ether(src=HOST[0], dst=MAC) / IP(src=HOST[1], dst=ADDRESS) / ICMP(type=0)]
    frames += [Ether(src=HOST[0], dst=mac) / arp for mac in (ALL, MAC, STRANGER[0])] + [Ether(src=HOST[0], dst=ALL) / ARP(op=2, pdst=ADDRESS)]
    frames += [Ether(src=HOST[0], dst=MAC) / Dot1Q(vlan=3) / IP(src=HOST[1], dst=ADDRESS) / UDP(sport=HOST[2], dport=PORT) / Raw(b"VLAN")]
    frames += [Ether(src=HOST[0], dst=MAC, type=0x86DD) / Raw(bytes(60)), Ether(src=HOST[0], dst=MAC) / IP(src=HOST[1], dst=ADDRESS, proto=6) / Raw(bytes(40))]
    return [bytes(frame) for frame in frames]


def summed(frame, chance):
    """The frame with its sums put right, or the UDP sum taken away, each by chance, so that changes get deep into the rules."""
    if len(frame) >= 34 and chance.random() < 0.5:
        frame[24:26] = b"\0\0"
        frame[24:26] = checksum(bytes(frame[14:34])).to_bytes(2, "big")
    if len(frame) >= 42 and frame[23] == 17 and chance.random() < 0.4:
        frame[40:42] = b"\0\0"
    return frame


def changed(frame, chance):
    """One byte of it another one: of its headers, mostly."""
    place = chance.randrange(min(len(frame), 46 if chance.random() < 0.7 else 2000))
    frame[place] = frame[place] ^ 1 << chance.randrange(8) if chance.random() < 0.5 else chance.randrange(256)


def mutant(all_seeds, chance):
    """(piece of what a PHY receives, place of its error or 0xffff)."""
    frame = bytearray(chance.choice(all_seeds))
    for _ in range(chance.choice((0, 0, 0, 1, 1, 2, 3))):
        changed(frame, chance)
    if chance.random() < 0.06:
        del frame[chance.randrange(14, len(frame) + 1) :]
    if chance.random() < 0.1:
        frame += chance.randbytes(chance.randrange(1, 60))
    frame = summed(frame, chance)
    if len(frame) < 60 and chance.random() < 0.97:
        frame += bytes(60 - len(frame))
    frame += zlib.crc32(frame).to_bytes(4, "little")
    if chance.random() < 0.06:
        frame[chance.randrange(len(frame))] ^= 1 << chance.randrange(8)
    if chance.random() < 0.02:
        del frame[chance.randrange(len(frame)) :]
    before = bytearray(PREAMBLE)
    if chance.random() < 0.04:
        before = bytearray(chance.choice((PREAMBLE[1:], PREAMBLE[6:], PREAMBLE[7:], PREAMBLE[:7], b"\x55" + PREAMBLE, b"\x55\x54\xd5", b"\xd5\xd5", b"")))
    piece = bytes(before + frame)
    return piece, chance.randrange(len(piece)) if piece and chance.random() < 0.03 else 0xFFFF


def batch(count, chance, all_seeds):
    """So many pieces, each with its error and the silence behind it, and what the model says. Before the peer could be forgotten by the clock, a longer
    silence comes."""
    model, heard = Model(), 0
    for _ in range(count):
        piece, error = mutant(all_seeds, chance)
        said = model.judge(piece, error)
        silence = chance.randrange(8, 21)
        heard = 0 if said[0] & ACCEPTED else heard + len(piece) + 20
        if heard > PEER_CLOCKS // 2 or chance.random() < 1e-4:
            silence, model.peer, heard = PEER_CLOCKS + 100, None, 0
        yield piece, error, silence, said


# ---- The comparison


def outcomes(output):
    """What the receiver said of each piece, as the model says it."""
    at = 0
    while at < len(output):
        *said, size = struct.unpack_from("<BBHHBH", output, at)
        at += 9 + size
        yield (*said, output[at - size : at])


def main(program):
    count = int(os.environ.get("HAPTOGRAM_NET_FRAMES", "40000"))
    seed = int(os.environ.get("HAPTOGRAM_SEED") or random.randrange(1 << 32))
    chance, all_seeds, kinds = random.Random(seed), seeds(), Counter()
    for first in range(0, count, BATCH):
        sent = list(batch(min(BATCH, count - first), chance, all_seeds))
        asked = b"".join(struct.pack("<HHI", len(piece), error, silence) + piece for piece, error, silence, _ in sent)
        found = list(outcomes(subprocess.run([program], input=asked, stdout=subprocess.PIPE, check=True).stdout))
        if len(found) != len(sent):
            return f"net_frames: {len(found)} outcomes of {len(sent)} frames, seed {seed}"
        for number, ((piece, error, _, said), got) in enumerate(zip(sent, found, strict=True), first):
            if any(want not in (None, have) for want, have in zip(said, got, strict=True)):
                return f"net_frames: frame {number} of seed {seed}, error at {error}: found {got}, expected {said}, of {piece.hex()}"
            kinds[said[0]] += 1
    names = {0: "nothing", ACCEPTED: "accepted", REFUSED: "refused", DAMAGED: "damaged", ANSWERS: "answered", ANSWERS | DISABLES: "DISABLE", ANSWERS | STOPS: "STOP"}
    print(f"{count} frames of seed {seed}: " + ", ".join(f"{kinds[flags]} {name}" for flags, name in names.items()))
    lacking = [name for flags, name in names.items() if kinds[flags] < count // 5000]
    return f"net_frames: too few of these to tell: {', '.join(lacking)}" if lacking else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
