"""Bags that `marco log convert` writes, played by Debian's `rosbag play` to a node of rospy: it hears every message, byte by
byte, of the type and checksum that the bag says.

usage: rosbag_play_peer.py MARCO_LOG RECORDING...
"""
import collections
import hashlib
import pathlib
import sys
import tempfile
import threading
import time

import rosbag
import rospy
from ros1_graph import master, play
from written_peer import convert


class Heard:
    def __init__(self, topics):
        self.lock = threading.Lock()
        self.counts, self.types = collections.Counter(), {}
        self.hashes = collections.defaultdict(hashlib.md5)
        self.subscribers = [rospy.Subscriber(topic, rospy.AnyMsg, self.take, topic) for topic in topics]

    def take(self, message, topic):
        with self.lock:
            self.counts[topic] += 1
            self.types[topic] = (message._connection_header['type'], message._connection_header['md5sum'])
            self.hashes[topic].update(message._buff)

    def close(self):
        for subscriber in self.subscribers:
            subscriber.unregister()


def written(path):
    counts, types, hashes = collections.Counter(), {}, collections.defaultdict(hashlib.md5)
    with rosbag.Bag(str(path)) as bag:
        for topic, (kind, data, md5sum, _, _), _ in bag.read_messages(raw=True):
            counts[topic] += 1
            types[topic] = (kind, md5sum)
            hashes[topic].update(data)
    return counts, types, hashes


def check(path):
    counts, types, hashes = written(path)
    heard = Heard(counts)
    player = play(path, '--rate', '10')
    player.wait()
    counts.pop('/rosout', None)  # where the player itself talks, too
    for _ in range(50):
        if all(heard.counts[topic] >= count for topic, count in counts.items()):
            break
        time.sleep(0.1)
    heard.close()
    faults = [] if player.returncode == 0 and counts else [f'rosbag play of {path} ended with {player.returncode}']
    for topic, count in counts.items():
        if heard.counts[topic] != count:
            faults.append(f'{path} {topic}: {heard.counts[topic]} of {count} messages arrived')
        elif heard.types[topic] != types[topic] or heard.hashes[topic].digest() != hashes[topic].digest():
            faults.append(f'{path} {topic}: arrived otherwise than written')
    print(f'{path.name}: {sum(heard.counts.values())} messages of {len(counts)} topics played')
    return faults


def main(marco_log, *recordings):
    faults = []
    with tempfile.TemporaryDirectory() as folder, master(folder):
        rospy.init_node('listener', disable_signals=True, disable_rosout=True)
        for i, source in enumerate(recordings):
            bag = pathlib.Path(folder) / f'{i}_{pathlib.Path(source).stem}.bag'
            convert(marco_log, source, bag)
            faults += check(bag)
        rospy.signal_shutdown('done')
    print(*faults, sep='\n')
    return 1 if faults else 0


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
