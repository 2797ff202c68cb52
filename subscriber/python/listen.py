#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Listens to loopsift: a line a second about the pose, the map and how the program feels. Python's own library is enough."""
import argparse
import math
import pathlib
import sys
import time

from loopsift_bus import Bus
from loopsift_subscriber import Subscriber
from loopsift_types import Types

STATES = ["starting", "tracking", "lost", "no source", "finishing"]


def find_messages():
    here = pathlib.Path(__file__).resolve()
    for folder in (here.parents[1] / "msgs", here.parents[2] / "msgs"):  # installed, in the tree
        if folder.is_dir():
            return folder
    return "msgs"


def line(subscriber):
    pose, health = subscriber.pose(), subscriber.health
    text = STATES[health.state] if health else "no health yet"
    if pose:
        sigma = math.sqrt(sum(pose.covariance[7 * k] for k in range(3)))
        text += " at " + " ".join(f"{v:.2f}" for v in pose.T_map_body.trans) + f" m (known to {sigma:.3f} m)"
    fragments = len(subscriber.graph.get("fragments", []))
    state = "complete" if subscriber.map_complete() else "on its way"
    return f"{text}, {len(subscriber.corrections)} corrections, {len(subscriber.loops)} loops, map of {fragments} fragments {state}"


def save_points(subscriber, path):
    points = list(subscriber.surfels())
    with open(path, "w", encoding="ascii") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
                   "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n")
        for x, y, z, *color in points:
            file.write(f"{x:.5f} {y:.5f} {z:.5f} {' '.join(map(str, color))}\n")
    print(f"{path}: {len(points)} points")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--group", default="239.255.76.67")
    parser.add_argument("--port", type=int, default=7667)
    parser.add_argument("--prefix", default="", help="before each channel's name")
    parser.add_argument("--msgs", default=find_messages(), help="folder of the .lcm files")
    parser.add_argument("--seconds", type=float, default=math.inf, help="end after so long")
    parser.add_argument("--map", help="write the map's points to this file once all are here, and end")
    arguments = parser.parse_args()
    subscriber = Subscriber(Bus(arguments.group, arguments.port), Types(arguments.msgs), arguments.prefix)
    end, told = time.monotonic() + arguments.seconds, time.monotonic()
    while time.monotonic() < end:
        subscriber.handle(0.05)
        subscriber.poll()
        if time.monotonic() - told >= 1:
            told = time.monotonic()
            print(line(subscriber), flush=True)
        if arguments.map and subscriber.map_complete():
            print(line(subscriber))
            save_points(subscriber, arguments.map)
            return 0
    return 0 if subscriber.pose() else 1


if __name__ == "__main__":
    sys.exit(main())
