"""ROS' own python3-rosbag and our reader on the same bags: the same messages, times, bytes and values of scans.

usage: rosbag_peer.py ROS_DIGEST BAG...
"""
import struct
import subprocess
import sys
import zlib

import rosbag


def digest(path):
    topics = {}
    with rosbag.Bag(path) as bag:
        for topic, (type_name, data, _, _, message_class), time in bag.read_messages(raw=True):
            entry = topics.setdefault(f'{topic} {type_name}', [0, 0, 0, 0.0])
            entry[0] += 1
            entry[1] = zlib.crc32(data, zlib.crc32(struct.pack('<q', time.to_nsec()), entry[1]))
            if type_name == 'sensor_msgs/LaserScan':
                scan = message_class()
                scan.deserialize(data)
                entry[2] = zlib.crc32(struct.pack(f'<{len(scan.ranges)}f', *scan.ranges), entry[2])
                entry[3] += (scan.angle_min + scan.angle_increment + scan.range_max +
                             1e-9 * scan.header.stamp.to_nsec())
    return {f'{path} {topic} {n} {crc:08x} {ranges:08x} {angles:.6f}' for topic, (n, crc, ranges, angles) in
            topics.items()}


def main(program, *bags):
    wrong = 0
    for bag in bags:
        ours = set(subprocess.run([program, bag], check=True, capture_output=True, text=True).stdout.splitlines())
        theirs = digest(bag)
        print(f'{bag}: {len(theirs)} topics, {len(ours ^ theirs)} differences')
        for line in sorted(ours ^ theirs):
            print('  ' + ('ours:   ' if line in ours else 'theirs: ') + line)
        wrong += len(ours ^ theirs) + (not theirs)
    return 1 if wrong else 0


if __name__ == '__main__':
    if len(sys.argv) < 3:
        print('SKIPPED: no bags, MARCO_TEST_DATA is not set')
        sys.exit(0)
    sys.exit(main(*sys.argv[1:]))
