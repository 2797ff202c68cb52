# SPDX-License-Identifier: MIT
"""The map before and after correction, and which way is up.

map.ply holds the corrected map. A fragment is rigid, so the map before is each fragment's surfels moved by
T_odom_camera · T_map_camera⁻¹ of the fragment's first frame.
"""
import numpy as np

from surfel_renderer import Surfels


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
