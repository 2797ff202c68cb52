#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Labels the true loops of a rendered sequence, to measure proposals by with `loopsift-tool eval-loops`.

SEQUENCE is a folder that `loopsift-tool synth SCENE --no-noise --no-distortion --no-color --out SEQUENCE` wrote (a small
image is enough: SCENE?width=160&height=120). Fragment k is frames 50 k to 50 k + 49, placed at the first of them. Two
fragments that are no neighbours and overlap by more than 0.3 are a loop, as Choi et al. (2015) label them: the part of the
one's surface, in 5 cm voxels, that has the other's within about 5 cm. Surface is what the camera of such a scene sees,
0.4 to 4.5 m away. Writes OUT.log and OUT.info (redwood: the true
transform, and the information of the shared points)."""
import argparse
import itertools
import os

import numpy as np
from PIL import Image

FRAGMENT_FRAMES, VOXEL_M, MIN_OVERLAP, EVERY = 50, 0.05, 0.3, 5
MIN_DEPTH_M, MAX_DEPTH_M = 0.4, 4.5  # of the camera that `loopsift --source synth:SCENE` has


def poses(path):
    matrices = []
    for row in np.loadtxt(path, ndmin=2):
        x, y, z, w = row[4:8]
        T = np.eye(4)
        v, cross = row[4:7], np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        T[:3, :3] = np.eye(3) + 2 * w * cross + 2 * (np.outer(v, v) - v @ v * np.eye(3))
        T[:3, 3] = row[1:4]
        matrices.append(T)
    return matrices


def points(image, camera):
    depth = np.asarray(Image.open(image), float) / camera["depth_scale"]
    v, u = np.nonzero((depth > MIN_DEPTH_M) & (depth < MAX_DEPTH_M))
    z = depth[v, u]
    return np.stack([(u - camera["cx"]) / camera["fx"] * z, (v - camera["cy"]) / camera["fy"] * z, z], 1)


def keys(cells):
    return (cells[:, 0] << 42) + (cells[:, 1] << 21) + cells[:, 2]


def voxels(cloud):
    return np.unique(np.floor(cloud / VOXEL_M).astype(np.int64) + (1 << 20), axis=0)


def shared(cells, others):
    """Of each cell: whether the others have it or one that shares a face with it."""
    steps = np.array([s for s in itertools.product((-1, 0, 1), repeat=3) if np.abs(s).sum() <= 1])
    return np.isin(keys(cells)[:, None] + keys(steps)[None, :], keys(others)).any(axis=1)


def information(cloud):
    """Sum of GᵀG with G = [I | −2[p]×]: redwood's order (t, vector part of the quaternion)."""
    total = np.zeros((6, 6))
    for x, y, z in cloud:
        G = np.hstack([np.eye(3), -2 * np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])])
        total += G.T @ G
    return total


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence")
    parser.add_argument("out")
    arguments = parser.parse_args()
    with open(os.path.join(arguments.sequence, "camera.txt"), encoding="ascii") as file:
        camera = {line.split()[0]: float(line.split()[1]) for line in file}
    T = poses(os.path.join(arguments.sequence, "groundtruth.txt"))
    images = sorted(os.listdir(os.path.join(arguments.sequence, "depth")))
    count = (len(T) + FRAGMENT_FRAMES - 1) // FRAGMENT_FRAMES
    surfaces = []
    for f in range(count):
        frames = range(FRAGMENT_FRAMES * f, min(len(T), FRAGMENT_FRAMES * (f + 1)), EVERY)
        clouds = [
            points(os.path.join(arguments.sequence, "depth", images[k]), camera) @ T[k][:3, :3].T + T[k][:3, 3]
            for k in frames
        ]
        surfaces.append(voxels(np.concatenate(clouds)))
    with open(arguments.out + ".log", "w", encoding="ascii") as log, open(
        arguments.out + ".info", "w", encoding="ascii"
    ) as info:
        for i, j in itertools.combinations(range(count), 2):
            common = shared(surfaces[i], surfaces[j])
            if j - i < 2 or max(common.mean(), shared(surfaces[j], surfaces[i]).mean()) <= MIN_OVERLAP:
                continue
            T_i_world = np.linalg.inv(T[FRAGMENT_FRAMES * i])
            centres = (surfaces[i][common] - (1 << 20) + 0.5) * VOXEL_M @ T_i_world[:3, :3].T + T_i_world[:3, 3]
            for file, matrix in ((log, T_i_world @ T[FRAGMENT_FRAMES * j]), (info, information(centres))):
                file.write(f"{i} {j} {count}\n")
                file.writelines(" ".join(f"{x:.8e}" for x in row) + "\n" for row in matrix)


if __name__ == "__main__":
    main()
