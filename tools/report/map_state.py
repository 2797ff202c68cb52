# SPDX-License-Identifier: MIT
"""The map before and after correction, which way is up, and where its fragments disagree.

map.ply holds the corrected map. A fragment is rigid, so the map before is each fragment's surfels moved by
T_odom_camera · T_map_camera⁻¹ of the fragment's first frame.
"""
import numpy as np

from surfel_renderer import Surfels

CELL_M = 0.08       # edge of the cells in which a fragment's surface is taken for a plane
SAME_SIDE = 0.7     # cosine between normals of one surface: the two sides of a thin wall do not match
ASIDE_M = 0.05      # patches are compared where they lie over each other, to this much
MAX_PARTNERS = 40   # fragments that all are compared with: every n-th of a long run
MAX_PAIRS = 4000000  # looked at together, which bounds memory


def rotation(q):
    """Matrix of a quaternion x y z w."""
    x, y, z, w = q / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def pose_at(trajectory, time_s):
    """Rotation and position of the row of a TUM trajectory nearest in time."""
    row = trajectory[np.argmin(np.abs(trajectory[:, 0] - time_s))]
    return rotation(row[4:8]), row[1:4]


def before_correction(after, odometry, corrected):
    """The surfels where the odometry has them; None when the map does not say which fragment they are of."""
    if after.fragment is None:
        return None
    points, normals = after.points.copy(), after.normals.copy()
    ends = np.searchsorted(after.fragment, np.arange(len(after.first_frame_s) + 1))
    for k, time_s in enumerate(after.first_frame_s):
        R_odom, p_odom = pose_at(odometry, time_s)
        R_map, p_map = pose_at(corrected, time_s)
        R = R_odom @ R_map.T
        part = slice(ends[k], ends[k + 1])
        points[part] = (after.points[part] - p_map) @ R.T + p_odom
        normals[part] = after.normals[part] @ R.T
    return Surfels(points, normals, after.colors, after.radii, after.fragment, after.first_frame_s)


def find_up(surfels, trajectory):
    """The normal that most level surfaces share, near the camera's own up: mean shift over the normals."""
    up = np.mean([-rotation(q)[:, 1] for q in trajectory[:: max(1, len(trajectory) // 200), 4:8]], axis=0)
    up /= np.linalg.norm(up)
    normals = surfels.normals[:: max(1, len(surfels.normals) // 50000)].astype(float)
    for sharpness in (5, 10, 20, 40, 80, 160, 160):
        cosine = normals @ up
        mean = (np.exp(sharpness * (cosine - 1))[:, None] * normals)[cosine > 0.5].sum(axis=0)
        if not np.linalg.norm(mean) > 0:
            break
        up = mean / np.linalg.norm(mean)
    return up.astype(np.float32)


def patches(surfels):
    """A plane per fragment, cell and rough direction: cell, fragment, point, normal; and the patch of each surfel."""
    cell = np.floor(surfels.points / CELL_M).astype(np.int64)
    cell -= cell.min(axis=0) - 1
    size = cell.max(axis=0) + 2
    number = (cell[:, 0] * size[1] + cell[:, 1]) * size[2] + cell[:, 2]
    side = np.argmax(np.abs(surfels.normals), axis=1) * 2
    side += np.take_along_axis(surfels.normals, side[:, None] // 2, axis=1)[:, 0] > 0
    key = (number * (surfels.fragment.max() + 1) + surfels.fragment) * 6 + side
    _, first, patch, count = np.unique(key, return_index=True, return_inverse=True, return_counts=True)
    mean = [np.bincount(patch, weights=values) / count for values in (*surfels.points.T, *surfels.normals.T)]
    normal = np.stack(mean[3:], axis=1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-9)[:, None]
    return number[first], surfels.fragment[first], np.stack(mean[:3], axis=1), normal, patch, size


def disagreement(surfels):
    """Distance along the normal from each surfel to the patch of another fragment that lies over it, m: of several the
    farthest, since neighbours in time always agree. Up to about CELL_M; NaN where no other fragment saw the surface."""
    number, fragment, point, normal, patch, size = patches(surfels)
    compared = np.flatnonzero(fragment % (fragment.max() // MAX_PARTNERS + 1) == 0)
    order = compared[np.argsort(number[compared], kind="stable")]
    sorted_number = number[order]
    largest, match = np.full(len(number), -1.0), np.full(len(number), -1)
    steps = [(dx * size[1] + dy) * size[2] + dz for dx in (-1, 0, 1) for dy in (-1, 0, 1) for dz in (-1, 0, 1)]
    for step in steps:
        begin = np.searchsorted(sorted_number, number + step)
        count = np.searchsorted(sorted_number, number + step, side="right") - begin
        block = np.cumsum(count) // MAX_PAIRS
        for part in np.split(np.arange(len(number)), np.flatnonzero(np.diff(block)) + 1):
            mine = np.repeat(part, count[part])
            before = np.cumsum(count[part]) - count[part]
            other = order[np.repeat(begin[part] - before, count[part]) + np.arange(len(mine))]
            along = np.einsum("ij,ij->i", normal[mine], normal[other])
            fits = (fragment[mine] != fragment[other]) & (along > SAME_SIDE)
            mine, other = mine[fits], other[fits]
            apart = point[mine] - point[other]
            gap = np.abs(np.einsum("ij,ij->i", normal[other], apart))
            over = (np.einsum("ij,ij->i", apart, apart) - gap ** 2 < ASIDE_M ** 2) & (gap > largest[mine])
            mine, other, gap = mine[over], other[over], gap[over]
            small_first = np.argsort(gap, kind="stable")  # of several matches of a patch the farthest stays
            largest[mine[small_first]] = gap[small_first]
            match[mine[small_first]] = other[small_first]
    partner = match[patch]
    gap = np.abs(np.einsum("ij,ij->i", normal[partner], surfels.points - point[partner]))
    return np.where(partner >= 0, gap, np.nan)
