"""Python's sqlite3 and our reader on the same .db3 files: the same messages, times and bytes.

usage: db3_peer.py ROS_DIGEST DB3...
"""
import sqlite3
import struct
import sys
import zlib

import digests


def digest(path):
    database = sqlite3.connect(f'file:{path}?immutable=1', uri=True)
    names = {number: f'{name} {kind.replace("/msg/", "/")}'
             for number, name, kind in database.execute('SELECT id, name, type FROM topics')}
    topics = {}
    for number, time_ns, data in database.execute('SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp, id'):
        entry = topics.setdefault(names[number], [0, 0])
        entry[0] += 1
        entry[1] = zlib.crc32(data, zlib.crc32(struct.pack('<q', time_ns), entry[1]))
    return {f'{path} {topic} {n} {crc:08x}' for topic, (n, crc) in topics.items()}


if __name__ == '__main__':
    sys.exit(digests.compare(*sys.argv[1:], digest=digest, values=False))
