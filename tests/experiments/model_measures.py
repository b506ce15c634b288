"""What model_peers.py measures: of registered scans how well they agree, of a mesh what it leaves out, doubles and invents."""
import re

import numpy as np
import open3d as o3d

NEAR_M, PAIR_M, SHEET_M, SAMPLE_M2 = 0.10, 0.15, 0.02, 4e-4  # as tests/experiments/surface.cpp


def read_ply(path):
    """What marco writes: vertices with normals (or None), triangles."""
    with open(path, "rb") as file:
        data = file.read()
    start = data.index(b"end_header\n") + 11
    head = data[:start].decode()
    vertices, faces = (int(re.search(rf"element {what} (\d+)", head)[1]) for what in ("vertex", "face"))
    names = re.findall(r"property (float|uchar) (\w+)", head)
    kind = np.dtype([(name, "<f4" if of == "float" else "u1") for of, name in names])
    table = np.frombuffer(data, kind, vertices, start)
    corners = np.frombuffer(data, np.dtype([("n", "u1"), ("i", "<i4", 3)]), faces, start + vertices * kind.itemsize)["i"]
    at = np.stack([table[axis] for axis in "xyz"], 1).astype(float)
    normals = np.stack([table[axis] for axis in ("nx", "ny", "nz")], 1).astype(float) if "nx" in kind.names else None
    return at, normals, corners


def cloud(points):
    return o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))


def residuals(clouds):
    """Points to the planes of their nearest neighbours in the scan before or after: median, p90 [m], part with a neighbour."""
    models = []
    for points in clouds:
        models.append(cloud(points))
        models[-1].estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(radius=0.15, max_nn=30))
    found, asked = [], 0
    for a, b in [(i, i + 1) for i in range(len(clouds) - 1)] + [(i + 1, i) for i in range(len(clouds) - 1)]:
        tree, at, normals = o3d.geometry.KDTreeFlann(models[b]), clouds[b], np.asarray(models[b].normals)
        for point in clouds[a][::10]:
            asked += 1
            count, index, _ = tree.search_hybrid_vector_3d(point, PAIR_M, 1)
            if count:
                found.append(abs(normals[index[0]] @ (point - at[index[0]])))
    return np.median(found), np.quantile(found, 0.9), len(found) / asked


def judge(path, returns):
    """Part of the returns without surface within 10 cm; part of the area with a second sheet within 2 cm behind it; part of the
    area without a return within 10 cm; area."""
    vertices, _, triangles = read_ply(path)
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3d.core.Tensor(vertices.astype(np.float32)), o3d.core.Tensor(triangles.astype(np.uint32)))
    bare = np.mean(scene.compute_distance(o3d.core.Tensor(returns.astype(np.float32))).numpy() >= NEAR_M)
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    cross = np.cross(b - a, c - a)
    areas = 0.5 * np.linalg.norm(cross, axis=1)
    units = cross / np.maximum(2 * areas, 1e-30)[:, None]
    draw = np.random.default_rng(1)
    number = draw.choice(len(areas), int(areas.sum() / SAMPLE_M2), p=areas / areas.sum())
    u, v = draw.random((2, len(number)))
    u, v = np.where(u + v > 1, (1 - u, 1 - v), (u, v))
    at = a[number] + u[:, None] * (b - a)[number] + v[:, None] * (c - a)[number]
    unseen = o3d.geometry.PointCloud.compute_point_cloud_distance(cloud(at), cloud(returns))
    depth, doubled = np.full(len(number), 1e-3), np.zeros(len(number), bool)
    left = np.arange(len(number))
    while len(left) > 0:
        normal = units[number[left]]
        rays = np.concatenate([at[left] - depth[left, None] * normal, -normal], 1).astype(np.float32)
        hit = scene.cast_rays(o3d.core.Tensor(rays))
        depth[left] += hit["t_hit"].numpy() + 1e-3
        within = depth[left] < SHEET_M
        same = np.einsum("ij,ij->i", units[np.where(within, hit["primitive_ids"].numpy(), 0)], normal) >= 0.7
        doubled[left[within & same]] = True
        left = left[within & ~same]
    return bare, doubled.mean(), np.mean(np.asarray(unseen) >= NEAR_M), areas.sum()
