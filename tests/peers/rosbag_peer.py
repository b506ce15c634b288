"""ROS' own python3-rosbag and our reader on the same bags: the same messages, times, bytes and values of scans.

usage: rosbag_peer.py ROS_DIGEST BAG...
"""
import struct
import sys
import zlib

import rosbag

import digests


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


if __name__ == '__main__':
    sys.exit(digests.compare(*sys.argv[1:], digest=digest))
