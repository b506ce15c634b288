#!/usr/bin/env python3
"""Marco's 3D models beside Open3D's, on the same scans: registration, surface, and distance to the truth.

usage: model_peers.py FOLDER_OF_PROGRAMS --scans FOLDER [--world TOML --tour TOML] [--short] [--keep FOLDER]

--scans: a folder of uos *.3d with *.pose, as MARCO_TEST_DATA/nodding_lms. --world: also simulates a tour there, whose surface
is known exactly. --short: of Open3D's surfaces the one that takes seconds. Needs python3-open3d.
Exit code 1 when Marco's residual, or its part of returns without surface, is more than 5 % above the best of Open3D's
surfaces of the same returns that have no more second sheets than Marco's (or 1 %).
"""
import argparse
import glob
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time

import numpy as np
import open3d as o3d

from model_measures import cloud, judge, read_ply, residuals

SCALES_M = ((0.20, 0.6), (0.10, 0.3), (0.05, 0.15))  # voxel and search radius of each round of ICP


# ---- files

def write_ply(path, vertices, triangles):
    """As read_ply of Marco's: three floats a vertex."""
    faces = np.zeros(len(triangles), np.dtype([("n", "u1"), ("i", "<i4", 3)]))
    faces["n"], faces["i"] = 3, triangles
    with open(path, "wb") as file:
        file.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\n"
                   f"property float z\nelement face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n".encode())
        file.write(np.asarray(vertices, "<f4").tobytes() + faces.tobytes())


def read_scans(folder):
    """[(points in the scanner's frame [m], world_from_scanner)]: x ahead, y left, z up; by .pose, in the plane, as Marco starts."""
    scans = []
    for path in sorted(glob.glob(f"{folder}/*.3d")):
        right, up, ahead = 0.01 * np.loadtxt(path, comments="#")[:, :3].T
        points = np.stack([ahead, -right, up], 1)
        ranges = np.linalg.norm(points, axis=1)
        with open(path[:-3] + ".pose", encoding="utf-8") as file:
            x, _, z, _, turn, _ = map(float, file.read().split())
        c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
        pose = np.eye(4)
        pose[:2] = [[c, s, 0, 0.01 * z], [-s, c, 0, -0.01 * x]]
        scans.append((points[(ranges >= 0.48) & (ranges < 32.7)], pose))
    return scans


def sweeps_of(path):
    """model_scenes.ply as [(points, normals)], one a sweep: no triangle joins two."""
    at, normals, corners = read_ply(path)
    spans = np.zeros(len(at) + 1, int)
    np.add.at(spans, corners.min(1) + 1, 1)
    np.add.at(spans, corners.max(1) + 1, -1)
    cuts = list(np.flatnonzero(np.cumsum(spans)[:-1] == 0)) + [len(at)]
    return [(at[a:b], normals[a:b]) for a, b in zip(cuts, cuts[1:])]


# ---- Open3D

def with_normals(points, towards):
    """@param towards: a point a normal faces, or directions it agrees with."""
    made = cloud(points)
    made.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(radius=0.15, max_nn=30))
    normals = np.array(made.normals)
    outward = towards - points if towards.ndim == 1 else towards
    normals[np.einsum("ij,ij->i", normals, outward) < 0] *= -1
    made.normals = o3d.utility.Vector3dVector(normals)
    return made


def icp(scans):
    """Each scan to the one before it: point to plane, Tukey's kernel, from coarse to fine. @returns poses."""
    registration = o3d.pipelines.registration
    poses = [scans[0][1]]
    for (fixed, fixed_pose), (moving, moving_pose) in zip(scans, scans[1:]):
        step = np.linalg.inv(fixed_pose) @ moving_pose
        for voxel, radius in SCALES_M:
            source, target = (cloud(points).voxel_down_sample(voxel) for points in (moving, fixed))
            for one in (source, target):
                one.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(radius=3 * voxel, max_nn=30))
            kernel = registration.TukeyLoss(k=radius)
            step = registration.registration_icp(
                source, target, radius, step, registration.TransformationEstimationPointToPlane(kernel),
                registration.ICPConvergenceCriteria(1e-7, 1e-7, 100)).transformation
        poses.append(poses[-1] @ step)
    return poses


def more_icp(clouds):
    """Whether ICP finds a better place for scans that are placed and straightened."""
    poses = icp([(points, np.eye(4)) for points in clouds])
    return [points @ pose[:3, :3].T + pose[:3, 3] for points, pose in zip(clouds, poses)]


def poisson(points, depth):
    mesh, density = o3d.geometry.TriangleMesh.create_from_point_cloud_poisson(points, depth=depth)
    density = np.asarray(density)
    mesh.remove_vertices_by_mask(density < np.quantile(density, 0.05))
    return mesh


def pivoting(points):
    thin = points.voxel_down_sample(0.02)
    return o3d.geometry.TriangleMesh.create_from_point_cloud_ball_pivoting(thin, o3d.utility.DoubleVector([0.02, 0.04, 0.08, 0.16]))


SURFACES = {"Poisson, depth 9": lambda points: poisson(points, 9), "Poisson, depth 10": lambda points: poisson(points, 10),
            "ball pivoting": pivoting}


def step(what, source, out):
    """One part of Open3D's work, in a process of its own: its time and memory are measured."""
    given = np.load(source, allow_pickle=True)
    if what == "icp":
        np.save(out, icp([(points, pose) for points, pose in zip(given["points"], given["poses"])]))
        return
    mesh = SURFACES[what](with_normals(given["points"], given["towards"]))
    write_ply(out, np.asarray(mesh.vertices), np.asarray(mesh.triangles))


# ---- the comparison

def timed(command):
    """@returns seconds of CPU and of the clock that the command took with its children, what it printed."""
    begin, before = time.time(), resource.getrusage(resource.RUSAGE_CHILDREN)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as child:
        printed = child.stdout.read()
    if child.returncode not in (0, 3):  # 3: marco-map doubts its map
        sys.exit(f"{' '.join(command)}\n{printed}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return (cpu, time.time() - begin), printed


def open3d(what, folder, out, **given):
    source = os.path.join(folder, "given.npz")
    np.savez(source, **given)
    cost, printed = timed([sys.executable, os.path.abspath(__file__), "--step", what, source, out])
    return cost + (float(re.search(r"peak (\d+) kB", printed)[1]) / 1000,)


def marco_map(options, recording, out):
    cost, _ = timed([f"{options.programs}/marco-map", recording, "--out", out, "--sweep-meshes"])
    with open(f"{out}/report.json", encoding="utf-8") as file:
        return cost + (json.load(file)["peak_memory_mb"],)


def said(cost):
    return f"{cost[0]:6.1f} {cost[1]:6.1f} {cost[2]:6.0f}"


def compare_scans(options, folder):
    """@returns whether Marco is equal or better."""
    cost = marco_map(options, options.scans, f"{folder}/scans")
    sweeps = sweeps_of(f"{folder}/scans/model_scenes.ply")
    scans = read_scans(options.scans)
    if len(sweeps) != len(scans):
        sys.exit(f"{len(scans)} scans, but {len(sweeps)} sweeps in model_scenes.ply")
    points = np.empty(len(scans), object)
    points[:] = [scan for scan, _ in scans]
    icp_cost = open3d("icp", folder, f"{folder}/icp.npy", points=points, poses=np.array([pose for _, pose in scans]))
    poses = np.load(f"{folder}/icp.npy")
    by_icp = [scan @ pose[:3, :3].T + pose[:3, 3] for (scan, _), pose in zip(scans, poses)]
    print("registration                       median    p90 [mm]  with a neighbour within 15 cm   CPU wall [s] MB")
    rows = [("start", [scan @ pose[:3, :3].T + pose[:3, 3] for scan, pose in scans], ""),
            ("Open3D, point to plane ICP", by_icp, said(icp_cost)),
            ("Marco (all of its work)", [at for at, _ in sweeps], said(cost)),
            ("the same, then Open3D's ICP", more_icp([at for at, _ in sweeps]), "")]
    figures = {}
    for name, clouds, price in rows:
        figures[name] = residuals(clouds)
        median, p90, part = figures[name]
        print(f"{name:34} {1e3 * median:6.2f}  {1e3 * p90:6.2f}  {100 * part:6.1f} %                        {price}", flush=True)
    theirs, ours = figures["Open3D, point to plane ICP"], figures["Marco (all of its work)"]
    same = {"points": np.concatenate([at for at, _ in sweeps]), "towards": np.concatenate([to for _, to in sweeps])}
    own = {"points": np.concatenate(by_icp), "towards": np.concatenate([pose[:3, 3] - at for at, pose in zip(by_icp, poses)])}
    print("surface                            no surface within 10 cm  second sheets within 2 cm  area without a return near  area [m2]   CPU wall [s] MB")
    ours_surface = judge(f"{folder}/scans/model.ply", same["points"])
    show_surface("Marco (all of its work)", ours_surface, cost)
    best = 1.0
    for name, given in surfaces(options, same, own):
        out = f"{folder}/surface.ply"
        price = open3d(name, folder, out, **given)
        found = judge(out, given["points"])
        show_surface(f"Open3D {name}" + (", after ICP" if given is own else ""), found, price)
        if given is same and found[1] <= max(ours_surface[1], 0.01):
            best = min(best, found[0])
    return ours[0] <= 1.05 * theirs[0] and ours[1] <= 1.05 * theirs[1] and ours_surface[0] <= 1.05 * best


def surfaces(options, same, own):
    """Of Marco's placed returns, which shows the surface alone, and of ICP's."""
    if options.short:
        return [("ball pivoting", same)]
    return [(name, same) for name in SURFACES] + [("Poisson, depth 10", own)]


def show_surface(name, found, cost):
    print(f"{name:34} {100 * found[0]:6.2f} %                 {100 * found[1]:6.2f} %                   {100 * found[2]:6.2f} %                 "
          f"{found[3]:8.1f}   {said(cost)}",
          flush=True)


def compare_simulated(options, folder):
    log, out = f"{folder}/world.lcm", f"{folder}/world"
    timed([f"{options.programs}/marco-simulate", "--world", options.world, "--tour", options.tour, "--seed", "1", "--out", log])
    cost = marco_map(options, log, out)
    at, normals, _ = read_ply(f"{out}/model_scenes.ply")
    print("simulated, against the truth       rms    p99 [mm]  coverage   CPU wall [s] MB")
    made = [("Marco (all of its work)", f"{out}/model.ply", cost)]
    for name in SURFACES:
        path = f"{folder}/{name.replace(' ', '_')}.ply"
        made.append((f"Open3D {name}", path, open3d(name, folder, path, points=at, towards=normals)))
    for name, path, price in made:
        _, text = timed([f"{options.programs}/marco-evaluate-model", path, options.world, "--beams", log, "--trajectory",
                         f"{out}/trajectory.tum"])
        rms, p99 = (1e3 * float(re.search(rf"\nerror: .* {what}=([\d.]+)", text)[1]) for what in ("rms", "p99"))
        covered = re.search(r"coverage: ([\d.]+) %", text)[1]
        print(f"{name:34} {rms:6.1f}  {p99:6.1f}  {covered:>6} %   {said(price)}", flush=True)


def main():
    if sys.argv[1:2] == ["--step"]:
        step(*sys.argv[2:])
        with open("/proc/self/status", encoding="utf-8") as file:  # what wait4 says begins with the parent's memory
            print("peak", re.search(r"VmHWM:\s*(\d+) kB", file.read())[1], "kB")
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs")
    parser.add_argument("--scans", required=True)
    parser.add_argument("--world")
    parser.add_argument("--tour")
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--keep")
    options = parser.parse_args()
    if not glob.glob(f"{options.scans}/*.3d"):
        print(f"SKIPPED: no *.3d in '{options.scans}', MARCO_TEST_DATA is not set")
        return
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or temporary
        os.makedirs(folder, exist_ok=True)
        version = subprocess.run([f"{options.programs}/marco-map", "--version"], capture_output=True, text=True, check=True).stdout
        print(f"{version.strip()}, Open3D {o3d.__version__}")
        good = compare_scans(options, folder)
        if options.world:
            compare_simulated(options, folder)
    print("Marco is " + ("equal or better in residuals and" if good else "worse in residuals or") + " returns without surface")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
