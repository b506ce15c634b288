"""A tutorial: a recording as arrays, two scans matched, the map and its path.     ./marco python examples/lesson.py [LOG]

Draws lesson.png if matplotlib is installed.
"""
import pathlib
import sys

import numpy as np

import marco

path = sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[1] / "logs/sample.lcm"

# 1. What is in the recording?
recording = marco.read(path)
print(f"{path}: {recording.format}, {len(recording.scans)} scans, {len(recording.odometry)} poses of odometry")
scan = recording.scans[0]
print(f"the first scan has {len(scan)} beams, {np.isfinite(scan.ranges).sum()} of them returned,"
      f" the nearest from {np.nanmin(scan.ranges):.2f} m")

# 2. How did the robot move between two scans? By the scans alone.
later = recording.scans[min(20, len(recording.scans) - 1)]
match = marco.match(scan.points(), later.points())
x, y, heading = match.pose
sigma = np.sqrt(np.diag(np.linalg.inv(match.information))) if match.converged else np.full(3, np.nan)
print(f"{later.time - scan.time:.1f} s later: {x:+.3f} m, {y:+.3f} m, {np.degrees(heading):+.2f} deg"
      f" (sd {1e3 * sigma[0]:.1f} mm, {1e3 * sigma[1]:.1f} mm), overlap {match.overlap:.0%}")

# 3. The map of the whole drive.
result = marco.map(path)
steps = np.diff(result.trajectory[:, 1:3], axis=0)
print(f"a map of {result.grid.shape[1]} x {result.grid.shape[0]} cells, a path of {np.hypot(*steps.T).sum():.1f} m,"
      f" {result.loops} loops; the verdict: {result.verdict}")
for reason in result.reasons:
    print("  because", reason)

# 4. A picture.
try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError:
    print("no picture: install matplotlib (python3-matplotlib)")
    sys.exit()
height, width = result.grid.shape
left, bottom = result.origin
extent = (left, left + width * result.resolution, bottom, bottom + height * result.resolution)
plt.imshow(np.where(result.grid == 255, 30, result.grid), cmap="gray_r", origin="lower", extent=extent, vmin=0, vmax=100)
plt.plot(result.odometry[:, 1], result.odometry[:, 2], ":", color="tab:gray", label="odometry")
plt.plot(result.trajectory[:, 1], result.trajectory[:, 2], color="tab:red", label="path")
plt.gca().set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
plt.legend()
plt.savefig("lesson.png", dpi=150)
print("lesson.png is drawn")
