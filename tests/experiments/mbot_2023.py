#!/usr/bin/env python3
"""Rewrites a log of MBot's older laser driver as the driver of 2023 would have filled it.

usage: mbot_2023.py IN.lcmlog OUT.lcmlog

RPLIDAR_LASER becomes LIDAR: thetas = 2 pi - angle, so that they rise counter-clockwise, with the beams in that order;
utime is the end of the turn; times begin at its begin and run along the array, against the order of measurement.
All else stays. What Marco makes of both logs is to be the same.
"""
import math
import struct
import sys

SYNC = b"\xed\xa1\xda\x01"
LIDAR_T = bytes.fromhex("89dc5b879a5056cf")


def rewritten(data):
    utime, beams = struct.unpack(">qi", data[8:20])
    floats, times = f">{beams}f", f">{beams}q"
    ranges = struct.unpack_from(floats, data, 20)
    thetas = struct.unpack_from(floats, data, 20 + 4 * beams)
    measured = struct.unpack_from(times, data, 20 + 8 * beams)
    intensities = struct.unpack_from(floats, data, 20 + 16 * beams)
    turn_us = (measured[-1] - measured[0]) * beams // max(1, beams - 1)
    angles = [(2.0 * math.pi - theta) % (2.0 * math.pi) for theta in reversed(thetas)]
    along = [measured[0] + turn_us * i // beams for i in range(beams)]
    return (LIDAR_T + struct.pack(">qi", measured[0] + turn_us, beams) +
            struct.pack(floats, *reversed(ranges)) + struct.pack(floats, *angles) +
            struct.pack(times, *along) + struct.pack(floats, *reversed(intensities)))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1], "rb") as log:
        content = log.read()
    scans = at = 0
    with open(sys.argv[2], "wb") as out:
        while at + 28 <= len(content):
            if content[at:at + 4] != SYNC:
                at += 1
                continue
            number, time, name_bytes, data_bytes = struct.unpack(">qqii", content[at + 4:at + 28])
            name = content[at + 28:at + 28 + name_bytes]
            data = content[at + 28 + name_bytes:at + 28 + name_bytes + data_bytes]
            at += 28 + name_bytes + data_bytes
            if data.startswith(LIDAR_T):
                name, data = b"LIDAR", rewritten(data)
                scans += 1
            out.write(SYNC + struct.pack(">qqii", number, time, len(name), len(data)) + name + data)
    print(f"{scans} scans rewritten")


main()
