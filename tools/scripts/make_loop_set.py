#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes an input for `loopsift-tool sift` and `compare` from a true trajectory and labelled overlaps of fragments:
an odometry that drifts (noise, and a slowly changing bias scaled so that the end is off by --drift metres) and true
loops, 1-2 cm and 0.5-1 degree off, between fragments that overlap by more than 0.3.

Writes OUT/odometry.log, OUT/loops.log, OUT/loops.info, OUT/gt.log (redwood). The truth is a redwood .log with a pose
for each frame, or a folder of 7-Scenes (frame-NNNNNN.pose.txt); the overlaps are lines `i,j,overlap`, as 3DMatch's."""
import argparse
import glob
import os

import numpy as np

FRAGMENT_FRAMES = 50


def rotation(w):
    angle = np.linalg.norm(w)
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = w / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def rigid(t, w):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation(w), t
    return T


def direction(random):
    v = random.normal(size=3)
    return v / np.linalg.norm(v)


def read_truth(path):
    if os.path.isdir(path):
        return [np.loadtxt(f) for f in sorted(glob.glob(os.path.join(path, "frame-*.pose.txt")))]
    with open(path, encoding="ascii") as file:
        numbers = np.array(file.read().split(), float)
    return list(numbers.reshape(-1, 19)[:, 3:].reshape(-1, 4, 4))


def slow(random, count, period=150):
    """Smooth noise of unit size, one row per step."""
    kernel = np.exp(-0.5 * (np.arange(-3 * period, 3 * period + 1) / period) ** 2)
    noise = random.normal(size=(count + len(kernel) - 1, 3))
    smooth = np.stack([np.convolve(noise[:, k], kernel, mode="valid") for k in range(3)], axis=1)
    return smooth / np.sqrt((smooth ** 2).sum(1).mean())


def drifting(poses, end_drift_m, random):
    count = len(poses) - 1
    steps = [np.linalg.inv(poses[k]) @ poses[k + 1] for k in range(count)]
    bias_t = 2e-4 * direction(random) + 1e-4 * slow(random, count)
    bias_w = np.radians(0.01 * direction(random) + 0.004 * slow(random, count))
    noise_t, noise_w = random.normal(0, 1.2e-4, (count, 3)), np.radians(random.normal(0, 0.006, (count, 3)))

    def walk(scale):
        walked = [poses[0]]
        for k in range(count):
            walked.append(walked[-1] @ steps[k] @ rigid(noise_t[k] + scale * bias_t[k], noise_w[k] + scale * bias_w[k]))
        return walked

    low, high = 0.0, 40.0
    for _ in range(30):
        middle = (low + high) / 2
        far = np.linalg.norm(walk(middle)[-1][:3, 3] - poses[-1][:3, 3]) > end_drift_m
        low, high = (low, middle) if far else (middle, high)
    return walk((low + high) / 2)


def read_overlaps(path, fragments):
    with open(path, encoding="ascii") as file:
        rows = [line.split(",") for line in file if line.strip()]
    pairs = [(int(i), int(j)) for i, j, overlap in rows if float(overlap) > 0.3]
    return [(i, j) for i, j in pairs if i + 1 < j < fragments]


def write_log(path, records):
    with open(path, "w", encoding="ascii") as file:
        for (a, b, n), matrix in records:
            file.write(f"{a} {b} {n}\n" + "".join(" ".join(f"{x:.10f}" for x in row) + "\n" for row in matrix))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("truth")
    parser.add_argument("overlaps")
    parser.add_argument("out")
    parser.add_argument("--drift", type=float, default=0.25, help="metres at the end of the odometry (0.25)")
    parser.add_argument("--loops", type=int, default=20, help="true loops (20)")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    random = np.random.default_rng(arguments.seed)
    poses = read_truth(arguments.truth)
    fragments = len(poses) // FRAGMENT_FRAMES
    poses = poses[:fragments * FRAGMENT_FRAMES]
    pairs = read_overlaps(arguments.overlaps, fragments)
    loops = []
    for k in random.permutation(len(pairs))[:arguments.loops]:
        i, j = pairs[k]
        off = rigid(random.uniform(0.01, 0.02) * direction(random),
                    np.radians(random.uniform(0.5, 1.0)) * direction(random))
        T = np.linalg.inv(poses[i * FRAGMENT_FRAMES]) @ poses[j * FRAGMENT_FRAMES] @ off
        loops.append(((i, j, fragments), T))
    information = np.diag([1 / 0.02 ** 2] * 3 + [4 / np.radians(1) ** 2] * 3)  # (t, q_xyz): q is half the angle
    os.makedirs(arguments.out, exist_ok=True)
    for name, trajectory in (("gt", poses), ("odometry", drifting(poses, arguments.drift, random))):
        write_log(f"{arguments.out}/{name}.log", [((k, k, k + 1), T) for k, T in enumerate(trajectory)])
    write_log(f"{arguments.out}/loops.log", loops)
    write_log(f"{arguments.out}/loops.info", [(header, information) for header, _ in loops])


if __name__ == "__main__":
    main()
