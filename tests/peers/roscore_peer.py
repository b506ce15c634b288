"""A robot of ROS 1 on Debian's own rosmaster: `rosbag play` is its drivers, and nodes of rospy listen to what Marco gives back.
Between the graph and marco-bridge stands ros1_relay.mjs. SLAM's poses, map and transform are to come as messages that
ROS' own classes take.

usage: roscore_peer.py MARCO_BRIDGE MARCO_SLAM RECORDING.bag
"""
import collections
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import threading
import time

import geometry_msgs.msg
import nav_msgs.msg
import rosbag
import rospy
import tf2_msgs.msg
from ros1_graph import master, play

SCANS, SECONDS, RATE = 'sensor_msgs/LaserScan', 40, 2
CLASSES = {'geometry_msgs/PoseStamped': geometry_msgs.msg.PoseStamped, 'nav_msgs/OccupancyGrid': nav_msgs.msg.OccupancyGrid,
           'nav_msgs/Path': nav_msgs.msg.Path, 'tf2_msgs/TFMessage': tf2_msgs.msg.TFMessage}


class Relay:
    """The graph's side of ros1_relay.mjs."""

    def __init__(self):
        self.process = subprocess.Popen(['node', 'ros1_relay.mjs'], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.lock = threading.Lock()
        self.port = self.read()[0]['port']
        self.publishers, self.refused = {}, []
        threading.Thread(target=self.publish_all, daemon=True).start()

    def say(self, head, data=b''):
        text = json.dumps(head).encode()
        with self.lock:
            self.process.stdin.write(struct.pack('<II', 4 + len(text) + len(data), len(text)) + text + data)
            self.process.stdin.flush()

    def read(self):
        sizes = self.process.stdout.read(8)
        if len(sizes) < 8:
            return None
        size, head = struct.unpack('<II', sizes)
        frame = self.process.stdout.read(size - 4)
        return json.loads(frame[:head]), frame[head:]

    def announce(self, topic, kind, schema):
        self.say({'topic': topic, 'type': kind, 'schema': schema})
        return rospy.Subscriber(topic, rospy.AnyMsg, self.take, topic)

    def take(self, message, topic):
        if message._connection_header['callerid'] != rospy.get_name():
            self.say({'topic': topic, 'ns': time.time_ns()}, message._buff)

    def publish_all(self):
        """What a client publishes, into the graph."""
        while (frame := self.read()) is not None:
            topic, kind = frame[0]['topic'], frame[0]['type']
            try:
                message = CLASSES[kind]().deserialize(frame[1])
                if topic not in self.publishers:
                    self.publishers[topic] = rospy.Publisher(topic, CLASSES[kind], queue_size=1000)
                self.publishers[topic].publish(message)
            except Exception as error:  # pylint: disable=broad-except
                self.refused.append(f'{topic} ({kind}): {error!r}')


class Listener:
    """Another node's view of the graph."""

    def __init__(self):
        self.count, self.last, self.stamps = collections.Counter(), {}, set()
        for topic, kind in (('/slam_pose', 'geometry_msgs/PoseStamped'), ('/map', 'nav_msgs/OccupancyGrid'),
                            ('/marco/path', 'nav_msgs/Path')):
            rospy.Subscriber(topic, CLASSES[kind], self.take, topic)
        rospy.Subscriber('/tf', rospy.AnyMsg, self.take_transform)

    def take(self, message, topic):
        self.count[topic] += 1
        self.last[topic] = message
        if topic == '/slam_pose':
            self.stamps.add(message.header.stamp.to_nsec() // 1000)

    def take_transform(self, message):
        for transform in tf2_msgs.msg.TFMessage().deserialize(message._buff).transforms:
            if transform.header.frame_id == 'map' and transform.child_frame_id == 'odom':
                self.count['map to odom'] += 1


def run(bridge, slam, recording):
    relay, listener = Relay(), Listener()
    topics = {}
    with rosbag.Bag(recording) as bag:
        for connection in bag._get_connections():
            topics[connection.topic] = (connection.datatype, connection.msg_def)
        lasers = sorted(topic for topic, (kind, _) in topics.items() if kind == SCANS)
        end = rospy.Time(bag.get_start_time() + SECONDS)
        scans = collections.defaultdict(list)  # stamps in us, by laser
        for topic, message, _ in bag.read_messages(topics=lasers, end_time=end):
            scans[topic].append(message.header.stamp.to_nsec() // 1000)
    held = [relay.announce(topic, *topics[topic]) for topic in topics]
    programs = [subprocess.Popen(['timeout', '150', *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                for words in ((bridge, f'ws://127.0.0.1:{relay.port}'), (slam,))]
    time.sleep(2)
    player = play(recording, '--rate', str(RATE), '--duration', str(SECONDS))
    player.wait()
    time.sleep(2)
    for program in programs:
        program.terminate()
        program.wait()
    relay.process.stdin.close()
    relay.process.wait()
    del held
    # The bridge chooses a laser.
    used = max(lasers, key=lambda laser: len(listener.stamps.intersection(scans[laser])))
    posed = listener.stamps.intersection(scans[used])
    first = next((number for number, stamp in enumerate(scans[used]) if stamp in posed), len(scans[used]))
    lost = len(scans[used]) - first - len(posed)
    grid = listener.last.get('/map')
    occupied = sum(cell > 65 for cell in grid.data) if grid else 0
    print(f'{len(scans[used])} scans of {used} played, the first {first} while the bridge looked; {len(posed)} poses, {lost} '
          f'lost; {listener.count["/map"]} maps ({occupied} cells occupied), {listener.count["/marco/path"]} paths, '
          f'{listener.count["map to odom"]} transforms from map to odom')
    print(*relay.refused[:5], sep='\n')
    return (not relay.refused and len(posed) > len(scans[used]) / 2 and lost <= 5 and occupied > 100 and
            listener.count['/marco/path'] > 0 and listener.count['map to odom'] > len(posed) / 2)


def main(bridge, slam, recording):
    with tempfile.TemporaryDirectory() as folder, master(folder):
        rospy.init_node('robot', disable_signals=True, disable_rosout=True)
        good = run(bridge, slam, recording)
        rospy.signal_shutdown('done')
    if not good:
        print('FAILED')
    return 0 if good else 1


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
