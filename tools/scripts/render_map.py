#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Pictures of a map.ply: OUT_top.png from above (orthographic) and OUT_view.png from a raised corner (perspective).

Surfels are drawn as discs, nearest wins, colour shaded by the normal against two lamps (tools/report draws with the
same renderer). Surfels that face away are left out: one looks into a room through the backs of its walls and ceiling.
The floor is taken to be level with the first camera: up is -y of the map unless --up says otherwise. With --trajectory,
the camera's way is drawn from yellow (start) to red (end). Colours are reduced to 256, which keeps the files small.
"""
import argparse
import os
import sys

import numpy as np
from PIL import Image, ImageDraw

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "report"))
from surfel_renderer import CameraView, MapError, TopView, camera_axes, paint, read_map  # noqa: E402

PATH_ENDS = np.array([[255, 205, 25], [215, 25, 40]])
MARGIN = 16


def corner_view(points, up, size, turn_deg, tilt):
    center = np.median(points, axis=0)
    extent = np.percentile(np.linalg.norm(points - center, axis=1), 95)
    side = camera_axes(-up, up[[1, 2, 0]])[:2]
    angle = np.radians(turn_deg)
    eye = center + extent * (2.0 * (np.cos(angle) * side[0] + np.sin(angle) * side[1]) + 2.0 * tilt * up)
    field_of_view = 2 * np.arctan(0.5 / (0.9 * np.sqrt(1 + tilt * tilt)))
    return CameraView(eye, center - eye, up, size, size, field_of_view)


def draw_path(image, view, positions):
    u, v, depth = view.project(positions)
    pen = ImageDraw.Draw(image)
    for k in range(len(u) - 1):
        color = PATH_ENDS[0] + (PATH_ENDS[1] - PATH_ENDS[0]) * k / len(u)
        if np.all(np.isfinite(depth[k:k + 2])):
            pen.line([u[k], v[k], u[k + 1], v[k + 1]], fill=tuple(int(c) for c in color), width=3)


def crop(image):
    """What is drawn and a margin around it."""
    drawn = np.asarray(image) != 255
    rows, cols = np.flatnonzero(drawn.any(axis=(1, 2))), np.flatnonzero(drawn.any(axis=(0, 2)))
    if len(rows) == 0:
        return image
    return image.crop((max(cols[0] - MARGIN, 0), max(rows[0] - MARGIN, 0), min(cols[-1] + MARGIN, image.width),
                       min(rows[-1] + MARGIN, image.height)))


def render(surfels, view, keep, path):
    seen, brightness = view.see(surfels, keep)
    rgba = paint(seen, brightness, np.clip(surfels.colors, 0, 1) ** 0.7)
    rgb = rgba[..., :3] * rgba[..., 3:] + (1 - rgba[..., 3:])
    image = Image.fromarray(np.rint(255 * rgb).astype(np.uint8))
    if path is not None:
        draw_path(image, view, path)
    return crop(image)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map", help="map.ply of a run")
    parser.add_argument("out", help="start of the names of the pictures")
    parser.add_argument("--trajectory", help="trajectory.txt of the run: draw the camera's way")
    parser.add_argument("--size", type=int, default=1000, help="longer side at most, pixels (default 1000)")
    parser.add_argument("--up", type=float, nargs=3, default=[0, -1, 0], metavar=("X", "Y", "Z"), help="default 0 -1 0")
    parser.add_argument("--cut", type=float, default=0.0, help="leave out the highest so many metres")
    parser.add_argument("--turn-deg", type=float, default=40, help="direction of the raised corner (default 40)")
    parser.add_argument("--tilt", type=float, default=0.9, help="height of the corner over its distance (default 0.9)")
    arguments = parser.parse_args()

    up = np.array(arguments.up, np.float32)
    up /= np.linalg.norm(up)
    try:
        surfels = read_map(arguments.map)
    except (MapError, OSError) as error:
        sys.exit(f"render_map.py: {error}")
    height = surfels.points @ up
    keep = height <= np.percentile(height, 99.8) - arguments.cut if arguments.cut > 0 else np.ones(len(height), bool)
    path = np.loadtxt(arguments.trajectory, usecols=(1, 2, 3), ndmin=2) if arguments.trajectory else None
    shown = np.empty((0, 3)) if path is None else path
    views = {"top": TopView(surfels.points, shown, surfels.normals, up, arguments.size),
             "view": corner_view(surfels.points[keep], up, arguments.size, arguments.turn_deg, arguments.tilt)}
    for name, view in views.items():
        file = f"{arguments.out}_{name}.png"
        render(surfels, view, keep, path).quantize(256, kmeans=4).save(file, optimize=True)
        print(file)


if __name__ == "__main__":
    main()
