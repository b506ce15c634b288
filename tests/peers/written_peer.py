"""What `marco log convert` writes, read by other people: bags by ROS' own python3-rosbag, MCAP by its own readers from npm
(written_peer.mjs), and both by our reader, which must find the same bytes.

usage: written_peer.py MARCO_LOG ROS_DIGEST SAMPLE.lcm [RECORDING...]
"""
import pathlib
import subprocess
import sys
import tempfile

import genpy.dynamic
import rosbag
from rosbag_peer import digest


def convert(marco_log, source, target, *options):
    subprocess.run([marco_log, 'convert', source, target, *options], check=True, stdout=subprocess.DEVNULL)
    return target


def check_bag(ros_digest, path):
    """The same digests as ours; each definition gives the checksum that the connection says; scans deserialize."""
    ours = set(subprocess.run([ros_digest, path], check=True, capture_output=True, text=True).stdout.splitlines())
    theirs = digest(path)
    faults = [f'{path}: {line}' for line in sorted(ours ^ theirs)] + ([] if theirs else [f'{path}: is empty'])
    with rosbag.Bag(path) as bag:
        for connection in bag._get_connections():
            types = genpy.dynamic.generate_dynamic(connection.datatype, connection.msg_def)
            if types[connection.datatype]._md5sum != connection.md5sum:
                faults.append(f'{path}: the checksum of {connection.datatype} does not fit its definition')
        for _ in bag.read_messages():  # deserializes
            pass
    return faults


def main(marco_log, ros_digest, sample, *recordings):
    faults, mcaps = [], []
    with tempfile.TemporaryDirectory() as folder:
        for i, source in enumerate((sample, *recordings)):
            out = pathlib.Path(folder) / f'{i}_{pathlib.Path(source).stem}'
            for kind in ('bag', 'ros1', 'ros2', 'foxglove'):
                ending = '.bag' if kind == 'bag' else f'_{kind}.mcap'
                target = convert(marco_log, source, f'{out}{ending}', '--format', kind)
                if kind == 'bag':
                    faults += check_bag(ros_digest, target)
                else:
                    mcaps.append(target)
        said = subprocess.run(['node', 'written_peer.mjs', *mcaps], capture_output=True, text=True)
        print(said.stdout, said.stderr)
    for fault in faults:
        print(fault)
    return 1 if faults or said.returncode else 0


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
