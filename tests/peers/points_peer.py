"""Open3D and PCL on points that we wrote, and we on what they write: counts, extents and colours are the same.

usage: points_peer.py POINTS_DIGEST
"""
import os
import subprocess
import sys
import tempfile

import numpy as np
import open3d as o3d

POINTS = 5000
TOLERANCE_M = 2e-5


def digest(program, path, *more):
    """What points_digest prints of a file, by its first word."""
    text = subprocess.run([program, path, *more], check=True, capture_output=True, text=True).stdout
    lines = [line.split() for line in text.splitlines()]
    return {words[0]: words[1] if len(words) == 2 else [float(word) for word in words[1:]] for words in lines}


def cloud_of(points, colors):
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.colors = o3d.utility.Vector3dVector(colors / 255.0)
    return cloud


def compare(what, ours, points, colors=None, tolerance_m=TOLERANCE_M):
    """Our digest against arrays: N x 3 [m], N x 3 of 0..255."""
    assert int(ours["points"]) == len(points), (what, ours)
    extents = np.concatenate([points.min(axis=0), points.max(axis=0)])
    assert np.abs(np.array(ours["extents"]) - extents).max() < tolerance_m, (what, ours, extents)
    if colors is not None:
        assert int(ours["colors"][0]) == len(colors), (what, ours)
        # Open3D cuts colours off where it does not round them.
        assert np.abs(np.array(ours["colors"][1:]) - colors.mean(axis=0)).max() < 0.6, (what, ours, colors.mean(axis=0))
    print(f"{what}: as it should be")


def read_by_open3d(path):
    cloud = o3d.io.read_point_cloud(path)
    return np.asarray(cloud.points), np.asarray(cloud.colors) * 255.0


def theirs_read_by_us(program, folder, points, colors):
    kinds = [("ascii.pcd", {"write_ascii": True}), ("binary.pcd", {}), ("packed.pcd", {"compressed": True}),
             ("ascii.ply", {"write_ascii": True}), ("binary.ply", {}), ("plain.xyz", {}), ("colored.pts", {})]
    for name, how in kinds:
        path = os.path.join(folder, name)
        assert o3d.io.write_point_cloud(path, cloud_of(points, colors), **how), name
        compare(f"Open3D's {name}", digest(program, path), points, None if name.endswith("xyz") else colors,
                1e-4 if name == "ascii.ply" else TOLERANCE_M)  # Open3D writes six digits there


def ours_read_by_them(program, folder, points, colors):
    source = os.path.join(folder, "binary.ply")
    for form in ("pcd", "ply", "xyz", "pts"):
        path = os.path.join(folder, f"ours.{form}")
        ours = digest(program, source, "--to", form, path)
        seen, seen_colors = read_by_open3d(path)
        compare(f"our {form} in Open3D", ours, seen, None if form == "xyz" else seen_colors)
        assert np.abs(seen - points).max() < TOLERANCE_M, form
        if form != "xyz":
            assert np.abs(seen_colors - colors).max() < 0.6, form


def by_pcl(program, folder, points, colors):
    """Our PCD through PCL, in each of its three kinds."""
    ours = os.path.join(folder, "ours.pcd")
    for kind, name in enumerate(("ascii", "binary", "compressed")):
        path = os.path.join(folder, f"pcl_{name}.pcd")
        subprocess.run(["pcl_convert_pcd_ascii_binary", ours, path, str(kind)], check=True, stdout=subprocess.DEVNULL)
        compare(f"our pcd through PCL, {name}", digest(program, path), points, colors)


def far_points(program, folder, points, colors):
    """Coordinates of a survey keep their tenths of a millimetre."""
    far = points + np.array([558312.25, 5240857.5, 76.125])
    source = os.path.join(folder, "far.ply")
    assert o3d.io.write_point_cloud(source, cloud_of(far, colors))
    for form in ("ply", "xyz"):
        path = os.path.join(folder, f"ours_far.{form}")
        ours = digest(program, source, "--to", form, path)
        seen, _ = read_by_open3d(path)
        compare(f"our far {form} in Open3D", ours, seen)
        assert np.abs(seen - far).max() < TOLERANCE_M, form
    # Open3D reads no doubles from PCD; PCL does.
    path, through = os.path.join(folder, "ours_far.pcd"), os.path.join(folder, "pcl_far.pcd")
    digest(program, source, "--to", "pcd", path)
    subprocess.run(["pcl_convert_pcd_ascii_binary", path, through, "2"], check=True, stdout=subprocess.DEVNULL)
    compare("our far pcd through PCL", digest(program, through), far, colors)


def main():
    program = sys.argv[1]
    random = np.random.default_rng(7)
    points = random.uniform(-40.0, 40.0, (POINTS, 3)).astype(np.float32).astype(np.float64)
    colors = random.integers(0, 256, (POINTS, 3)).astype(np.float64)
    with tempfile.TemporaryDirectory() as folder:
        theirs_read_by_us(program, folder, points, colors)
        ours_read_by_them(program, folder, points, colors)
        by_pcl(program, folder, points, colors)
        far_points(program, folder, points, colors)


if __name__ == "__main__":
    main()
