"""Python's sqlite3 and our reader on the same .db3 files: the same messages, times and bytes.

usage: db3_peer.py ROS_DIGEST DB3...
"""
import sqlite3
import struct
import subprocess
import sys
import zlib


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


def main(program, *databases):
    wrong = 0
    for path in databases:
        lines = subprocess.run([program, path], check=True, capture_output=True, text=True).stdout.splitlines()
        ours = {line.rsplit(' ', 2)[0] for line in lines}  # without the values of scans
        theirs = digest(path)
        print(f'{path}: {len(theirs)} topics, {len(ours ^ theirs)} differences')
        for line in sorted(ours ^ theirs):
            print('  ' + ('ours:   ' if line in ours else 'theirs: ') + line)
        wrong += len(ours ^ theirs) + (not theirs)
    return 1 if wrong else 0


if __name__ == '__main__':
    if len(sys.argv) < 3:
        print('SKIPPED: no databases, MARCO_TEST_DATA is not set')
        sys.exit(0)
    sys.exit(main(*sys.argv[1:]))
