"""A ROS 1 of Debian's own parts (rosmaster, rospy, rosbag play) on loopback, for tests: a master, and messages as bytes.

Run the tests in a network of their own: the master's port is ROS' usual one.
"""
import contextlib
import os
import pathlib
import subprocess
import sys
import time

MASTER = 'http://127.0.0.1:11311'


def is_up():
    import rosgraph
    return rosgraph.is_master_online(MASTER)


@contextlib.contextmanager
def master(folder):
    """Its logs go to `folder`. Ends with the block."""
    os.environ.update(ROS_MASTER_URI=MASTER, ROS_IP='127.0.0.1', ROS_LOG_DIR=str(folder), ROS_HOME=str(folder))
    with open(pathlib.Path(folder) / 'master.txt', 'w') as log:
        process = subprocess.Popen(['timeout', '300', 'rosmaster', '--core'], stdout=log, stderr=log)
    try:
        for _ in range(200):
            if is_up():
                break
            if process.poll() is not None:
                sys.exit('rosmaster ended: ' + (pathlib.Path(folder) / 'master.txt').read_text())
            time.sleep(0.1)
        yield
    finally:
        process.terminate()
        process.wait()


def play(bag, *options):
    """`rosbag play`, which waits until somebody listens to each topic."""
    return subprocess.Popen(['timeout', '200', 'rosbag', 'play', '--quiet', '--wait-for-subscribers', '--queue', '0',
                             *options, str(bag)], stdout=subprocess.DEVNULL)
