#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Counts the true loops of a redwood .log: those within 0.10 m and 5 degrees of the true motion between the first
cameras of the two fragments. Fragment k is taken to begin at frame 50 k: right where every frame was tracked.
The truth is a trajectory with one pose per frame, TUM or redwood .log."""
import argparse

import numpy as np

FRAGMENT_FRAMES, MAX_M, MAX_DEG = 50, 0.10, 5.0


def rotation(qx, qy, qz, qw):
    v, cross = np.array([qx, qy, qz]), np.array([[0, -qz, qy], [qz, 0, -qx], [-qy, qx, 0]])
    return np.eye(3) + 2 * qw * cross + 2 * (np.outer(v, v) - v @ v * np.eye(3))


def read_log(path):
    """[(i, j, 4x4 matrix)]"""
    with open(path, encoding="ascii") as file:
        numbers = np.array(file.read().split(), float)
    return [(int(r[0]), int(r[1]), r[3:].reshape(4, 4)) for r in numbers.reshape(-1, 19)]


def read_truth(path):
    if path.endswith(".log"):
        return [T for _, _, T in read_log(path)]
    poses = []
    for row in np.loadtxt(path, ndmin=2):
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = rotation(*row[4:8]), row[1:4]
        poses.append(T)
    return poses


def is_true(truth, i, j, T_i_j):
    T_true = np.linalg.inv(truth[i * FRAGMENT_FRAMES]) @ truth[j * FRAGMENT_FRAMES]
    error = np.linalg.inv(T_true) @ T_i_j
    angle_deg = np.degrees(np.arccos(np.clip((np.trace(error[:3, :3]) - 1) / 2, -1, 1)))
    return np.linalg.norm(error[:3, 3]) <= MAX_M and angle_deg <= MAX_DEG


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("truth", help="true camera-to-world trajectory")
    parser.add_argument("loops", nargs="+", help="proposals.log, accepted.log")
    arguments = parser.parse_args()
    truth = read_truth(arguments.truth)
    for path in arguments.loops:
        loops = read_log(path)
        print(f"{path}: {sum(is_true(truth, *loop) for loop in loops)} true of {len(loops)}")


if __name__ == "__main__":
    main()
