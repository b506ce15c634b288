from os import PathLike
from typing import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Path = str | PathLike[str]


class Scan:
    """One sweep of a laser."""
    time: float  # of the first beam, seconds since 1970
    channel: str  # which laser
    ranges: NDArray[np.float32]  # m; nan: no return
    bearings: NDArray[np.float64]  # rad, counter-clockwise from ahead, laser frame

    def points(self) -> NDArray[np.float64]:
        """The returns as rows of x and y [m], laser frame."""
    def __len__(self) -> int: ...


class Recording:
    """The contents of a recording. Poses are rows of seconds since 1970, x [m], y [m], heading [rad]."""
    scans: list[Scan]
    odometry: NDArray[np.float64]  # odom frame
    imu: NDArray[np.float64]  # rows of seconds, angular velocity x y z [rad/s], acceleration x y z [m/s2]
    truth: NDArray[np.float64]  # of a simulator or motion capture
    format: str
    dropped: dict[str, int]  # data left out, by cause
    notes: list[str]  # assumptions and oddities


class Map:
    """A map with its path. Poses are rows of seconds since 1970, x [m], y [m], heading [rad], world frame."""
    trajectory: NDArray[np.float64]  # one per scan, with all loops closed
    live_trajectory: NDArray[np.float64]  # as first estimated at each scan
    odometry: NDArray[np.float64]  # as recorded, at the scans
    grid: NDArray[np.uint8]  # rows from low to high y: per cent occupied, 255: unknown
    resolution: float  # m per cell
    origin: tuple[float, float]  # m, of the corner of grid[0, 0]
    loops: int
    verdict: str  # good, doubtful or wrong
    reasons: list[str]  # why it is not good

    def save(self, folder: Path) -> None:
        """Writes map.pgm and map.yaml, as map_server reads them, and trajectory.tum."""


class Match:
    pose: NDArray[np.float64]  # x [m], y [m], heading [rad] of the source in the target's frame
    information: NDArray[np.float64]  # 3x3, inverse covariance of pose
    overlap: float  # fraction of the source's points on walls of the target
    converged: bool


def read(path: Path) -> Recording: ...
def map(recordings: Path | Sequence[Path], config: Path | None = None, lines: bool = False) -> Map: ...
def match(target: ArrayLike, source: ArrayLike, guess: ArrayLike = ...) -> Match:
    """Matches two scans given as points() in the order of their beams. guess: the pose to search around, by 1 m and 30
    degrees."""
def evaluate(trajectory: ArrayLike, relations: Path) -> dict: ...
def settings() -> str: ...


class Robot:
    """A running robot, or the simulator, over LCM. For one thread. Poses are (seconds, x, y, heading)."""
    def __init__(self, url: str = "") -> None:
        """url: an LCM URL; "": LCM_DEFAULT_URL, or this host alone."""
    def scan(self, timeout: float = 2.0) -> Scan:
        """The next scan. Raises TimeoutError if none arrives, as do the next three."""
    def odometry(self, timeout: float = 2.0) -> tuple[float, float, float, float]: ...
    def pose(self, timeout: float = 2.0) -> tuple[float, float, float, float]:
        """The next pose of SLAM."""
    def base(self, timeout: float = 2.0) -> str:
        """The note of the base's next status message."""
    def drive(self, velocity: float, yaw_rate: float = 0.0, seconds: float = 0.0) -> None:
        """m/s and rad/s (counter-clockwise). The base stops 0.5 s after the last order. With seconds: repeats the order
        during that time, then stops."""
    def go_to(self, x: float, y: float) -> None:
        """Turns and drives straight to a point of the odometry's frame; the obstacle guard stays on."""
    def stop(self) -> None: ...
