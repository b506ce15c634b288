"""Recordings as numpy arrays, maps of them, scan matching, and a live robot: see help(marco.read) and the others."""
import os as _os

from . import _marco
from ._marco import Map, Match, Recording, Robot, Scan, match

__all__ = ["Map", "Match", "Recording", "Robot", "Scan", "evaluate", "map", "match", "read", "settings"]


def read(path):
    """The recording at `path`, of any format that Marco knows: LCM and CARMEN logs, ROS bags, MCAP, rosbag2, ..."""
    return _marco._read(_os.fspath(path))


def map(recordings, config=None, lines=False):
    """The map of a recording, or of several as sessions of one building.

    config: a TOML file, see settings(). lines: by the line SLAM.
    """
    if isinstance(recordings, (str, _os.PathLike)):
        recordings = [recordings]
    return _marco._map([_os.fspath(path) for path in recordings], "" if config is None else _os.fspath(config), lines)


def evaluate(trajectory, relations):
    """Errors of a trajectory (rows of seconds, x, y, heading) against a file of relations, as a dict."""
    return _marco._evaluate(trajectory, _os.fspath(relations))


def settings():
    """All settings of map() as TOML, each with a description."""
    return _marco._settings()
